/* The digest of the routine's outputs over inputs first, first + stride, … */
#include "sweep.h"

#include "inputs.h"

uint64_t sweep(uint32_t first, uint64_t count, uint32_t stride)
{
    uint64_t digest = 0u;
    uint32_t index = first;

#if STATE
    begin(first);
#endif
    for (uint64_t left = count; left > 0u; left--) {
#if FLAG
        RESULT result = (RESULT)0;
        if (under_test(PASSED(index), &result) == 0) {
            digest += FLAGGED;
        }
#else
        const RESULT result = under_test(PASSED(index));
#endif
        digest += mixed(key_of(index), BITS(result));
        index += stride;
    }
    return digest;
}
