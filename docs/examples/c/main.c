/* The corrected angle of a few readings, with the C pair as it was generated and committed. */
#include <stdint.h>
#include <stdio.h>

#include "corrected_angle.h"

int main(void)
{
    for (int32_t tenths = -3; tenths <= 3; ++tenths) {
        /* s in tenths of a millimetre, as a word of which 2^31 stand for 0.5 mm. */
        const int32_t s_q31 = tenths * 429496730;
        const double angle_rad = (double)corrected_angle_q31(s_q31) / 4294967296.0;
        printf("s = %4.1f mm   angle = %+9.6f rad\n", 0.1 * (double)tenths, angle_rad);
    }
    return 0;
}
