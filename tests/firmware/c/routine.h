/*
 * The routine under test, named on the compiler's command line:
 *   HEADER     its generated header
 *   ROUTINE    its name; `nothing` for the firmware without it
 *   ARGUMENT   type of its arguments, ARGUMENTS how many: 1 or 2
 *   RESULT     type of its result
 *   FLAG       1 where it tells readings outside the range, otherwise 0
 *   SECOND     type of the second argument, where there are two
 *   STATE      1 where it keeps a state from call to call, so that there are ROUTINE_init and ROUTINE_update; 2 for
 *              the firmware without it
 */
#ifndef ROUTINE_H
#define ROUTINE_H

#include <stdint.h>

#include HEADER

#if ARGUMENTS == 1
#define PARAMETERS ARGUMENT first
#define PASSED(index) argument_of((uint32_t)(index))
#else
#define PARAMETERS ARGUMENT first, SECOND second
#define PASSED(index) first_of_two((uint32_t)(index)), second_of_two((uint32_t)(index))
#endif

#if FLAG
typedef int32_t called(PARAMETERS, RESULT *result);
#else
typedef RESULT called(PARAMETERS);
#endif

#ifndef STATE
#define STATE 0
#endif

/* Begins a sequence of calls with the input of this number. */
void begin(uint32_t index);

/* The routine; a pointer that stands in a file of its own, so that all other code is the same for every one. */
extern called *const under_test;

#endif
