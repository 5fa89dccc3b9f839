/*
 * A generated routine with a state, a reading and one further input, for a caller that keeps the state. The build
 * says which: HEADER "name.h", ROUTINE the function's name.
 */
#include <stddef.h>
#include <stdint.h>

#include HEADER

#define JOINED(a, b) a##b
#define NAMED(a, b) JOINED(a, b)
typedef NAMED(ROUTINE, _state) state;

size_t state_size(void)
{
    return sizeof(state);
}

void state_init(void *kept, int32_t reading, uint16_t further)
{
    NAMED(ROUTINE, _init)((state *)kept, reading, further);
}

int32_t state_update(void *kept, int32_t reading, uint16_t further)
{
    return NAMED(ROUTINE, _update)((state *)kept, reading, further);
}
