#ifndef SWEEP_H
#define SWEEP_H

#include <stdint.h>

/* The digest of the routine's outputs over `count` inputs: first, first + stride, … modulo 2^32. */
uint64_t sweep(uint32_t first, uint64_t count, uint32_t stride);

/*
 * Calls the routine, or where `empty` a function of the same signature that does nothing, on `count` inputs,
 * each between the entry of the called function and the entry of `called_back`: there an observer counts.
 * Gives the largest number of bytes of stack that a call took.
 */
uint32_t observe(int empty, uint32_t first, uint32_t count, uint32_t stride);

#endif
