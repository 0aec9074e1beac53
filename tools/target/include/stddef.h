/* For cppcheck with tools/target/c28x.xml and for clang as a 16-bit compiler: the types as the C28x compiler
 * defines them under EABI. For clang a pointer has 16 bits. tools/check-dialect finds in the syntax tree the
 * expressions that get one of these types without naming it. */
#ifndef TARGET_STDDEF_H
#define TARGET_STDDEF_H

typedef unsigned long size_t;
typedef long ptrdiff_t;
typedef long wchar_t;

#define NULL                   ((void *)0)
#define offsetof(type, member) __builtin_offsetof(type, member)

#endif
