/* For the compilers that replace that of the C28x in checks: declares the intrinsics that firmware or hal use
 * and that the C28x compiler knows without a header. On the C28x they are not calls, but move the value to
 * another register. */
#ifndef TARGET_C28X_H
#define TARGET_C28X_H

unsigned long __f32_bits_as_u32(float value);
float __u32_bits_as_f32(unsigned long bits);

/* glibc has functions of these names with double; a call graph is the same with both. */
#if !defined(__linux__)
float __fmin(float x, float y);
float __fmax(float x, float y);
#endif

#endif
