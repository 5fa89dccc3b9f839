/*
 * Calls a generated routine on many inputs. The build says which one:
 *   HEADER     "name.h"
 *   ROUTINE    the function
 *   ARGUMENT   type of its arguments, ARGUMENTS how many: 1 or 2
 *   RESULT     type of its result
 *   FLAG       1 where it tells whether the reading was inside the range
 * Arguments and results travel as the bits of 32-bit words, the low bits first (little-endian hosts).
 */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include HEADER

#if ARGUMENTS == 2
#define WORDS x[0], x[1]
#else
#define WORDS x[0]
#endif

void batch(size_t count, const uint32_t *first, const uint32_t *second, uint32_t *result, uint8_t *inside)
{
    size_t i;

    for (i = 0; i < count; i++) {
        ARGUMENT x[2];
        RESULT y;

        memcpy(&x[0], &first[i], sizeof x[0]);
        memcpy(&x[1], &second[i], sizeof x[1]);
#if FLAG
        inside[i] = (uint8_t)ROUTINE(WORDS, &y);
#else
        inside[i] = 1;
        y = ROUTINE(WORDS);
#endif
        memcpy(&result[i], &y, sizeof y);
    }
}
