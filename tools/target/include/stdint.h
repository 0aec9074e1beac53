/* For cppcheck with tools/target/c28x.xml and for clang as a 16-bit compiler: the exact-width types as the
 * C28x compiler defines them (SPRU514). Without this file cppcheck assumes that uint16_t is wider than int,
 * and misses the effects of a 16-bit int on shifts and products. int8_t and uint8_t do not exist there. */
#ifndef TARGET_STDINT_H
#define TARGET_STDINT_H

typedef int int16_t;
typedef unsigned int uint16_t;
typedef long int32_t;
typedef unsigned long uint32_t;
typedef long long int64_t;
typedef unsigned long long uint64_t;
typedef long intptr_t;
typedef unsigned long uintptr_t;

#define INT16_MIN  (-INT16_MAX - 1)
#define INT16_MAX  32767
#define INT32_MIN  (-INT32_MAX - 1)
#define INT32_MAX  2147483647L
#define INT64_MIN  (-INT64_MAX - 1)
#define INT64_MAX  9223372036854775807LL
#define UINT16_MAX 65535U
#define UINT32_MAX 4294967295UL
#define UINT64_MAX 18446744073709551615ULL

/* Under EABI a pointer, and what counts chars or elements, has 32 bits. */
#define INTPTR_MIN  INT32_MIN
#define INTPTR_MAX  INT32_MAX
#define UINTPTR_MAX UINT32_MAX
#define PTRDIFF_MIN INT32_MIN
#define PTRDIFF_MAX INT32_MAX
#define SIZE_MAX    UINT32_MAX

#define INT16_C(value)  value
#define INT32_C(value)  value##L
#define INT64_C(value)  value##LL
#define UINT16_C(value) value##U
#define UINT32_C(value) value##UL
#define UINT64_C(value) value##ULL

#endif
