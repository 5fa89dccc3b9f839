/* Runs a generated routine with a state over words from standard input, two each, and writes its results. */
#include <stdint.h>
#include <stdio.h>

#include "corrected_angle.h"

int main(void)
{
    corrected_angle_q31_state state;
    int32_t word[2];
    int first = 1;

    while (fread(word, sizeof word, 1, stdin) == 1) {
        int32_t result;

        if (first) {
            corrected_angle_q31_init(&state, word[0], (uint16_t)word[1]);
            first = 0;
        }
        result = corrected_angle_q31_update(&state, word[0], (uint16_t)word[1]);
        (void)fwrite(&result, sizeof result, 1, stdout);
    }
    return 0;
}
