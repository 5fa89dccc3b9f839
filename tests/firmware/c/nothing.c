/* A function of the routine's signature that does nothing; on a microcontroller, one instruction. */
#include "routine.h"

called nothing;

#if defined(__arm__)
__attribute__((naked))
#endif
#if FLAG
int32_t nothing(PARAMETERS, RESULT *result)
#else
RESULT nothing(PARAMETERS)
#endif
{
#if defined(__arm__)
    __asm__ volatile("bx lr");
#else
    (void)first;
#if ARGUMENTS == 2
    (void)second;
#endif
#if FLAG
    (void)result;
#endif
    return 0;
#endif
}
