/*
 * Standard input: pages, each as its length and bytes, the number of words and the words. Standard output: for each
 * page the loader's status, and where it is 0 the results.
 */
#include <stdint.h>
#include <stdio.h>

#include "corrected_angle.h"

static int read_word(uint32_t *word)
{
    return fread(word, sizeof *word, 1, stdin) == 1;
}

int main(void)
{
    static uint8_t page[4096];
    uint32_t bytes;

    while (read_word(&bytes)) {
        corrected_angle_coefficients coefficients = { { 0 } };
        uint32_t count;
        int32_t status;

        if ((bytes > sizeof page) || (fread(page, 1, bytes, stdin) != bytes) || !read_word(&count)) {
            return 1;
        }
        status = corrected_angle_load(&coefficients, page, bytes);
        (void)fwrite(&status, sizeof status, 1, stdout);
        while (count-- > 0u) {
            uint32_t word;
            int32_t result;

            if (!read_word(&word)) {
                return 1;
            }
            if (status == CORRECTED_ANGLE_OK) {
                result = corrected_angle(&coefficients, (int32_t)word);
                (void)fwrite(&result, sizeof result, 1, stdout);
            } else if (coefficients.c[0] != 0) {
                return 2;
            }
        }
    }
    return 0;
}
