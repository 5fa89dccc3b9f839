/*
 * What engineers write for Eq. 13, the corrected angle in radians for |s| <= 0.38 mm: to be compared with
 * generated routines. Numbers come from files that the comparison computes from the model: coefficients.inc,
 * linear.inc, quadratic.inc, words.inc. Beyond the range each gives about the value at its end.
 */
#ifndef ALTERNATIVES_H
#define ALTERNATIVES_H

#include <stdint.h>

/* Half the range, in millimetres. */
#define RANGE_MM 0.38

/* d, in millimetres. */
#define DISTANCE_MM 12.0

/* The formula in double precision, with the library's arctangent. */
double eq13_double(double s_mm);

/* The same in single precision. */
float eq13_float(float s_mm);

/* 1024 values over the range, interpolated linearly. */
float table_linear(float s_mm);

/* 64 parabolas over the range. */
float table_quadratic(float s_mm);

/*
 * After CMSIS-DSP's description of arm_linear_interp_q31: x has 12 bits of index and 20 of fraction, the table
 * is of Q31 values. Here 1025 values over +-0.5 mm; the result is in 2^-33 rad, the argument in 2^-31 of 0.5 mm.
 */
int32_t linear_interp_q31(int32_t s_q31);

#endif
