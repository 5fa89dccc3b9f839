/* Arm's semihosting, IHI 0100: an operation in r0, its argument block in r1, `bkpt 0xab`. */
#include "semihosting.h"

#include <stdint.h>

enum { SYS_OPEN = 0x01, SYS_WRITE = 0x05, SYS_GET_CMDLINE = 0x15, SYS_EXIT_EXTENDED = 0x20 };

/* ADP_Stopped_ApplicationExit. */
static const uintptr_t APPLICATION_EXIT = 0x20026u;

static intptr_t call(intptr_t operation, const uintptr_t *block)
{
    register intptr_t r0 __asm__("r0") = operation;
    register const uintptr_t *r1 __asm__("r1") = block;

    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

void host_write(const char *text, size_t length)
{
    static intptr_t output = -1;

    if (output < 0) {
        /* ":tt", opened for writing, is standard output. */
        const uintptr_t open[3] = { (uintptr_t)":tt", 4u, 3u };
        output = call(SYS_OPEN, open);
    }
    const uintptr_t block[3] = { (uintptr_t)output, (uintptr_t)text, length };
    (void)call(SYS_WRITE, block);
}

const char *host_command_line(void)
{
    static char line[256];
    const uintptr_t block[2] = { (uintptr_t)line, sizeof line };

    return (call(SYS_GET_CMDLINE, block) == 0) ? line : "";
}

_Noreturn void host_exit(int code)
{
    const uintptr_t block[2] = { APPLICATION_EXIT, (uintptr_t)code };

    (void)call(SYS_EXIT_EXTENDED, block);
    for (;;) {
    }
}
