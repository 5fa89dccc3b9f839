/* The corrected position of a 14-bit encoder at eight places of the turn, and across the turn's end. */
#include <stdint.h>
#include <stdio.h>

#include "corrected_counts.h"

int main(void)
{
    for (uint32_t place = 0; place < 8; ++place) {
        const uint16_t count = (uint16_t)(2048u * place);
        printf("%5u -> %5u\n", (unsigned)count, (unsigned)corrected_counts(count));
    }
    for (uint32_t step = 0; step < 4; ++step) {
        const uint16_t count = (uint16_t)((16382u + step) % 16384u);
        printf("%5u -> %5u\n", (unsigned)count, (unsigned)corrected_counts(count));
    }
    return 0;
}
