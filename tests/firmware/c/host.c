/* The same commands on a computer with an operating system. */
#include "semihosting.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int firmware(const char *command_line);

void host_write(const char *text, size_t length)
{
    (void)fwrite(text, 1u, length, stdout);
}

/* Stack and instructions are counted on the target only. */
#include "sweep.h"
uint32_t observe(int empty, uint32_t first, uint32_t count, uint32_t stride)
{
    (void)empty;
    (void)first;
    (void)count;
    (void)stride;
    return 0u;
}

int main(int argc, char **argv)
{
    char line[1024] = "host";

    for (int i = 1; i < argc; i++) {
        (void)snprintf(line + strlen(line), sizeof line - strlen(line), " %s", argv[i]);
    }
    return firmware(line);
}
