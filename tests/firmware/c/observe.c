/* Calls for an observer outside, and how deep they go into the stack. */
#include "sweep.h"

#include "inputs.h"

static const uint32_t PAINT = 0xA5C33C5Au;

extern uint32_t stack_limit[];

/* The same signature as the routine; its count is what a call costs by itself. */
called nothing;

/* Where the count of a call ends. */
void called_back(void);
__attribute__((noinline)) void called_back(void)
{
    __asm__ volatile("" ::: "memory");
}

__attribute__((noinline)) static void call(called *function, uint32_t first, uint32_t count, uint32_t stride)
{
#if FLAG
    static RESULT result;
#endif

#if STATE
    begin(first);
#endif
    for (uint32_t i = 0u; i < count; i++) {
        const uint32_t index = first + i * stride;
#if FLAG
        (void)function(PASSED(index), &result);
#else
        (void)function(PASSED(index));
#endif
        called_back();
    }
}

__attribute__((noinline)) uint32_t observe(int empty, uint32_t first, uint32_t count, uint32_t stride)
{
    volatile uint32_t *top;
    volatile uint32_t *low = stack_limit;

    __asm__ volatile("mov %0, sp" : "=r"(top));
    for (volatile uint32_t *word = stack_limit; word < top; word++) {
        *word = PAINT;
    }
    call(empty ? nothing : under_test, first, count, stride);
    while ((low < top) && (*low == PAINT)) {
        low++;
    }
    return (uint32_t)((uintptr_t)top - (uintptr_t)low);
}
