/* The choice of the routine. */
#include "routine.h"

extern called nothing;

called *const under_test = ROUTINE;
