/*
 * Commands: sweep FIRST COUNT STRIDE …    prints the digest over all the sweeps, 16 hexadecimal digits
 *           observe FIRST COUNT STRIDE …  prints the bytes of stack that the routine takes
 * Numbers are hexadecimal without 0x.
 */
#include "semihosting.h"
#include "sweep.h"

int firmware(const char *command_line);

static const char *skip_word(const char *text)
{
    while ((*text != '\0') && (*text != ' ')) {
        text++;
    }
    while (*text == ' ') {
        text++;
    }
    return text;
}

static uint64_t number(const char **text)
{
    uint64_t value = 0u;

    for (const char *c = *text; (*c != '\0') && (*c != ' '); c++) {
        const uint32_t digit = (*c <= '9') ? (uint32_t)(*c - '0') : (uint32_t)(*c - 'a') + 10u;
        value = (value << 4) | (digit & 0xFu);
    }
    *text = skip_word(*text);
    return value;
}

static void print(uint64_t value)
{
    char text[17];

    for (int i = 0; i < 16; i++) {
        text[i] = "0123456789abcdef"[(value >> (60 - 4 * i)) & 0xFu];
    }
    text[16] = '\n';
    host_write(text, sizeof text);
}

int firmware(const char *command_line)
{
    /* The first word is the firmware's own name. */
    const char *command = skip_word(command_line);
    const char *rest = skip_word(command);
    uint64_t digest = 0u;
    uint32_t deepest = 0u, empty = 0u;

    if ((*command != 's') && (*command != 'o')) {
        return 2;
    }
    while (*rest != '\0') {
        const uint32_t first = (uint32_t)number(&rest);
        const uint64_t count = number(&rest);
        const uint32_t stride = (uint32_t)number(&rest);

        if (*command == 's') {
            digest += sweep(first, count, stride);
        } else {
            const uint32_t depth = observe(0, first, (uint32_t)count, stride);
            deepest = (depth > deepest) ? depth : deepest;
            empty = observe(1, first, 1u, stride);
        }
    }
    print((*command == 's') ? digest : deepest - empty);
    return 0;
}
