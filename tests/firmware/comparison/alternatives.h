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

/* Spacings of the float tables: of few bits, so that their multiples are exact. */
#define LINEAR_SPACING_MM 0x1.862p-11f
#define QUADRATIC_SPACING_MM 0x1.86p-7f

/* About d theta / d s, in rad/mm: what tables of floats leave to one multiplication. */
#define SLOPE 0.0715f

/* The formula in double precision, with the library's arctangent. */
double eq13_double(double s_mm);

/* The same in single precision. */
float eq13_float(float s_mm);

/* 1024 values over the range, interpolated linearly; built with care for single precision. */
float table_linear(float s_mm);

/* 64 parabolas over the range; likewise. */
float table_quadratic(float s_mm);

/*
 * After CMSIS-DSP's description of arm_linear_interp_q31: x has 12 bits of index and 20 of fraction, the table
 * is of Q31 values. Here 1025 values over +-0.5 mm; the result is in 2^-33 rad, the argument in 2^-31 of 0.5 mm.
 */
int32_t linear_interp_q31(int32_t s_q31);

/*
 * c + floor(a * b / 2^32), as those write it who know the core: a right shift of negative numbers is the compiler's.
 */
#if defined(__ARM_FEATURE_DSP)
#define MUL_ADD_HIGH(y, a, b, c) __asm__("smmla %0, %1, %2, %3" : "=r"(y) : "r"(a), "r"(b), "r"(c))
#else
#define MUL_ADD_HIGH(y, a, b, c) ((y) = (int32_t)(((int64_t)(a) * (b)) >> 32) + (c))
#endif

/* Horner's scheme of degree 9 with smmla; the argument in 2^-31 of 0.4 mm, the result in 2^-33 rad. */
int32_t horner_smmla(int32_t s_q31);

/* 32 parabolas of the whole argument with smmla, rows of three words; in 2^-31 of 0.76 mm, the result in 2^-32 rad. */
int32_t parabolas_smmla(int32_t s_q31);

#endif
