/* For the stand-ins of the C28x compiler: the intrinsics that it knows without a header and that firmware or
 * hal use. On the C28x they are not calls: the value moves to another register. */
#ifndef TARGET_C28X_H
#define TARGET_C28X_H

unsigned long __f32_bits_as_u32(float value);
float __u32_bits_as_f32(unsigned long bits);

/* glibc has functions of these names, with double: a graph of calls is the same with them. */
#if !defined(__linux__)
float __fmin(float x, float y);
float __fmax(float x, float y);
#endif

#endif
