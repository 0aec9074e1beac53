/* Common code of the fuzz targets: a random generator, mutations of octets, and a main function that runs
 * rounds until its time is over.
 *
 * usage of a target: PROGRAM SEED SECONDS [FOLDER...]
 *
 * It prints the seed of a round before the round fails; PROGRAM ROUND_SEED 0 runs this round again. */
#ifndef TESTS_FUZZ_FUZZ_H
#define TESTS_FUZZ_FUZZ_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static uint64_t fuzz_state, fuzz_round;

/* SplitMix64 */
static inline uint64_t fuzz_bits(void)
{
    uint64_t z = (fuzz_state += UINT64_C(0x9E3779B97F4A7C15));
    z = (z ^ (z >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94D049BB133111EB);
    return z ^ (z >> 31);
}

static inline uint32_t fuzz_below(uint32_t sides)
{
    return (uint32_t)(fuzz_bits() >> 32) % sides;
}

static inline void fuzz_expect(int good, const char *what)
{
    if (!good) {
        fprintf(stderr, "round %llu: %s\n", (unsigned long long)fuzz_round, what);
        abort();
    }
}

/* Makes one to eight changes: an octet changed or removed, a sequence doubled, the rest removed, or a
 * sequence of another text inserted. Returns the new length, at most `room`. */
static inline size_t fuzz_mutate(char *text, size_t count, size_t room, const char *other, size_t other_count)
{
    for (uint32_t n = 1u + fuzz_below(8u); n > 0u && count > 1u; n--) {
        const size_t at = fuzz_below((uint32_t)count);
        const size_t some = 1u + fuzz_below(40u);
        switch (fuzz_below(6u)) {
        case 0:
            text[at] = (char)fuzz_below(256u);
            break;
        case 1:
            text[at] = "0123456789-+.eE,:=[]\"'#\n \t{}"[fuzz_below(28u)];
            break;
        case 2:
            memmove(text + at, text + at + 1, count - at - 1u);
            count--;
            break;
        case 3:
            count = fuzz_below(8u) == 0u ? at + 1u : count;
            break;
        case 4: {
            const size_t length = some < count - at ? some : count - at;
            if (count + length <= room) {
                memmove(text + at + length, text + at, count - at);
                count += length;
            }
            break;
        }
        default: {
            const size_t from = other_count > 0u ? fuzz_below((uint32_t)other_count) : 0u;
            const size_t length = some < other_count - from ? some : other_count - from;
            if (count + length <= room) {
                memmove(text + at + length, text + at, count - at);
                memmove(text + at, other + from, length);
                count += length;
            }
            break;
        }
        }
    }
    return count;
}

/* Runs rounds for this number of seconds, at least one. */
static inline int fuzz_run(int argc, char **argv, void (*round)(void))
{
    if (argc < 3) {
        fprintf(stderr, "usage: %s SEED SECONDS\n", argv[0]);
        return 2;
    }
    uint64_t seed = strtoull(argv[1], NULL, 10);
    const double seconds = strtod(argv[2], NULL);
    struct timespec begun;
    struct timespec now;
    unsigned long rounds = 0;
    clock_gettime(CLOCK_MONOTONIC, &begun);
    do {
        fuzz_round = seed;
        fuzz_state = seed;
        round();
        fuzz_state = seed;
        seed = fuzz_bits();
        rounds++;
        clock_gettime(CLOCK_MONOTONIC, &now);
    } while ((double)(now.tv_sec - begun.tv_sec) + 1e-9 * (double)(now.tv_nsec - begun.tv_nsec) < seconds);
    printf("%lu rounds\n", rounds);
    return 0;
}

/* ---- texts of folders ---- */

#define FUZZ_FILES  400u
#define FUZZ_OCTETS 65536u

typedef struct {
    char *text;
    size_t octets;
} fuzz_file_t;

#endif
