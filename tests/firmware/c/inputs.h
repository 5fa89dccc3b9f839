/*
 * Inputs by their number, 0 … 2^32 - 1, and the digest of outputs.
 *
 * One argument: its bit pattern is the number (16 bits: the lower half). Two of 16 bits: the halves of the
 * number. A reading and a further input of 16 bits: the reading rises with the number, to and fro by a thirty-second of
 * its range, and the other is scattered over twelve bits. Two wider ones: the number is the second, or as a float the difference, and the first is scattered.
 */
#ifndef INPUTS_H
#define INPUTS_H

#include <stdint.h>
#include <string.h>

#include "routine.h"

/* A fixed scattering of 32 bits. */
static inline uint32_t scatter(uint32_t index)
{
    const uint32_t h = index * 0x9E3779B1u;

    return (h ^ (h >> 15)) * 0x85EBCA77u;
}

static inline uint32_t bits_of_float(float value)
{
    uint32_t bits;

    memcpy(&bits, &value, sizeof bits);
    return bits;
}

static inline float float_of_bits(uint32_t bits)
{
    float value;

    memcpy(&value, &bits, sizeof value);
    return value;
}

static inline uint32_t bits_of_double(double value)
{
    uint64_t bits;

    memcpy(&bits, &value, sizeof bits);
    return (uint32_t)(bits >> 32) ^ (uint32_t)bits;
}

static inline double double_of_bits(uint32_t bits)
{
    const uint64_t wide = (uint64_t)bits << 32;
    double value;

    memcpy(&value, &wide, sizeof value);
    return value;
}

/* As the 32 bits that the digest sees. */
#define BITS(value) \
    _Generic((value), float: bits_of_float, double: bits_of_double, default: bits_of_integer)(value)

static inline uint32_t bits_of_integer(int32_t value)
{
    return (uint32_t)value;
}

#ifdef EVEN
/* Where a comparison wants readings spread evenly over -EVEN ... EVEN. */
#define FROM_BITS(bits) ((ARGUMENT)((double)(int32_t)(bits) * (EVEN / 2147483648.0)))
#else
#define FROM_BITS(bits) \
    _Generic((ARGUMENT)0, float: float_of_bits(bits), double: double_of_bits(bits), default: (ARGUMENT)(bits))
#endif

#if ARGUMENTS == 1
static inline ARGUMENT argument_of(uint32_t index)
{
    return FROM_BITS(index);
}

static inline uint32_t key_of(uint32_t index)
{
    return BITS(argument_of(index));
}
#elif STATE
static inline ARGUMENT first_of_two(uint32_t index)
{
    return (ARGUMENT)(index + (scatter(index) >> 5));
}

static inline SECOND second_of_two(uint32_t index)
{
    return (SECOND)(scatter(index + 1u) >> 20);
}

static inline uint32_t key_of(uint32_t index)
{
    return BITS(first_of_two(index)) * 0x27D4EB2Fu + BITS(second_of_two(index));
}
#else
static inline ARGUMENT first_of_two(uint32_t index)
{
    const uint32_t scattered = scatter(index);

    return _Generic((ARGUMENT)0,
        float: (float)(int32_t)scattered * 0x1p-32f,
        uint16_t: (ARGUMENT)(index >> 16),
        default: (ARGUMENT)scattered);
}

/* A sum with one NaN, whichever the difference is: which one an addition gives is left to the machine. */
static inline float sum_of(float first, uint32_t difference)
{
    const int is_nan = (difference & 0x7FFFFFFFu) > 0x7F800000u;

    return is_nan ? float_of_bits(0x7FC00000u) : (first + float_of_bits(difference));
}

static inline ARGUMENT second_of_two(uint32_t index)
{
    return _Generic((ARGUMENT)0, float: sum_of((float)first_of_two(index), index), default: (ARGUMENT)index);
}

static inline uint32_t key_of(uint32_t index)
{
    return BITS(first_of_two(index)) * 0x27D4EB2Fu + BITS(second_of_two(index));
}
#endif

/* What one input and output add to the digest. For a given input, a bijection of the output. */
static inline uint32_t mixed(uint32_t key, uint32_t output)
{
    const uint32_t h = (output ^ (key * 0x9E3779B1u)) * 0x85EBCA77u;

    return (h ^ (h >> 15)) * 0xC2B2AE3Du;
}

/* What a reading that was flagged as outside adds besides. */
static const uint64_t FLAGGED = 0x9E3779B97F4A7C15u;

#endif
