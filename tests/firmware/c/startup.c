/* Vector table and reset of a Cortex-M without an operating system. */
#include "semihosting.h"

#include <stdint.h>

extern uint32_t data_load[], data_start[], data_end[], bss_start[], bss_end[], stack_top[];

int firmware(const char *command_line);

void reset(void);
void reset(void)
{
#if defined(__ARM_FP)
    /* CPACR: full access to the floating-point unit, coprocessors 10 and 11. */
    *(volatile uint32_t *)0xE000ED88u |= 0xFu << 20;
    __asm__ volatile("dsb\n\tisb" ::: "memory");
#endif
    for (uint32_t *from = data_load, *to = data_start; to < data_end;) {
        *to++ = *from++;
    }
    for (uint32_t *to = bss_start; to < bss_end;) {
        *to++ = 0u;
    }
    host_exit(firmware(host_command_line()));
}

/* Any fault ends the run with a code that no check gives. */
static void fault(void)
{
    host_exit(99);
}

struct vectors {
    void *stack;
    void (*handlers[15])(void);
};

__attribute__((section(".vectors"), used)) static const struct vectors VECTORS = {
    stack_top, { reset, fault, fault, fault, fault, fault }
};

/* Nothing runs before or after: what a hosted C library calls around main. */
void _init(void);
void _init(void)
{
}
