/* For clang as a 16-bit compiler, which has no C library: the single-precision functions. The call tree of
 * the interrupt must not use them although they are declared here (tools/check-dialect). */
#ifndef TARGET_MATH_H
#define TARGET_MATH_H

float fabsf(float x);
float sqrtf(float x);
float floorf(float x);
float fmodf(float x, float y);
float sinf(float x);
float cosf(float x);
float tanf(float x);
float atan2f(float y, float x);
float expf(float x);
float logf(float x);
float powf(float x, float y);

#endif
