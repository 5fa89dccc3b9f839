/* The host's services through a breakpoint: text out, the command line in, an exit code. */
#ifndef SEMIHOSTING_H
#define SEMIHOSTING_H

#include <stddef.h>

/* Writes to the host's standard output. */
void host_write(const char *text, size_t length);

/* The command line, ended by 0; "" where there is none. */
const char *host_command_line(void);

/* Ends the run. */
_Noreturn void host_exit(int code);

#endif
