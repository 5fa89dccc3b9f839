#include "alternatives.h"

/* Constant first. */
#include "horner.inc"

/* 0.38 of 0.4, rounded inward. */
#define END 2040109465

int32_t horner_smmla(int32_t s_q31)
{
    const int32_t below = (s_q31 > END) ? END : s_q31;
    const int32_t x = (below < -END) ? -END : below;
    int32_t y;

    MUL_ADD_HIGH(y, C9, x, C8);
    MUL_ADD_HIGH(y, y, x, C7);
    MUL_ADD_HIGH(y, y, x, C6);
    MUL_ADD_HIGH(y, y, x, C5);
    MUL_ADD_HIGH(y, y, x, C4);
    MUL_ADD_HIGH(y, y, x, C3);
    MUL_ADD_HIGH(y, y, x, C2);
    MUL_ADD_HIGH(y, y, x, C1);
    MUL_ADD_HIGH(y, y, x, C0);
    return y;
}
