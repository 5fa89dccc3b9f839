/* The choice of the routine, and its state where it keeps one. */
#include "inputs.h"

extern called nothing;

#if STATE == 1
#define JOINED(a, b) a##b
#define NAMED(a, b) JOINED(a, b)

static NAMED(ROUTINE, _state) state;

static RESULT next(PARAMETERS)
{
    return NAMED(ROUTINE, _update)(&state, first, second);
}

called *const under_test = next;

void begin(uint32_t index)
{
    NAMED(ROUTINE, _init)(&state, PASSED(index));
}
#else
called *const under_test = ROUTINE;

#if STATE
void begin(uint32_t index)
{
    (void)index;
}
#endif
#endif
