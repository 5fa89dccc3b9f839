/*
 * A generated routine with a state and a reading, for a caller that keeps the state. The build says which: HEADER
 * "name.h", ROUTINE the function's name, FURTHER 1 where it takes a further input and 0 where it does not.
 */
#include <stddef.h>
#include <stdint.h>

#include HEADER

#define JOINED(a, b) a##b
#define NAMED(a, b) JOINED(a, b)
typedef NAMED(ROUTINE, _state) state;
#if FURTHER
#define INPUTS reading, further
#else
#define INPUTS reading
#endif

size_t state_size(void)
{
    return sizeof(state);
}

void state_init(void *kept, int32_t reading, uint16_t further)
{
    (void)further;
    NAMED(ROUTINE, _init)((state *)kept, INPUTS);
}

int32_t state_update(void *kept, int32_t reading, uint16_t further)
{
    (void)further;
    return NAMED(ROUTINE, _update)((state *)kept, INPUTS);
}
