/* Where code lives on silicon. One macro, so that no other file knows the compiler's pragmas. */
#ifndef HAL_F28335_SECTION_H
#define HAL_F28335_SECTION_H

/* HAL_IN_RAM(f), in front of the definition of f: f is copied to RAM by the start-up code and runs there.
 * Needed by what changes the flash wait states, because the flash must not be read meanwhile. Nothing on the
 * host. */
#if defined(__TMS320C2000__)
#define SECTION_PRAGMA_(text) _Pragma(#text)
#define HAL_IN_RAM(f)         SECTION_PRAGMA_(CODE_SECTION(f, "ramfuncs"))
#else
#define HAL_IN_RAM(f)
#endif

#endif
