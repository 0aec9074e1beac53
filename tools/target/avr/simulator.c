/* An ATmega2560 with external RAM up to 64 K and twice its flash, 512 K, run by libsimavr: 16-bit int, 32-bit
 * double. Three registers without other use are the interface to the PC:
 *
 *     GPIOR0 written: a character for standard output
 *     GPIOR1 written: the end; the value is the exit code
 *     GPIOR2 read:    the next octet of the input; 0 when there is none left
 *
 * The input begins with two numbers of 32 bits, lowest octet first: the seed of the random shares
 * (LAGLESS_GRID_SEED, the date), and n of LAGLESS_GRID_SHARE (1), by which one test in n is run. A file
 * follows.
 *
 * usage: avr_simulator PROGRAM.elf [INPUT] */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>

enum { GPIOR0 = 0x3E, GPIOR1 = 0x4A, GPIOR2 = 0x4B }; /* data addresses */

enum { CRASHED = 99, WRONG_USE = 2 };

static FILE *input;
static unsigned char shares[8]; /* the first octets of the input */
static unsigned passed;         /* octets of the input that were read */
static int exit_code = -1;

static void on_character(struct avr_t *avr, avr_io_addr_t address, uint8_t value, void *context)
{
    (void)avr;
    (void)address;
    (void)context;
    putchar(value);
}

static void on_exit_code(struct avr_t *avr, avr_io_addr_t address, uint8_t value, void *context)
{
    (void)address;
    (void)context;
    exit_code = value;
    avr->state = cpu_Done;
}

static uint8_t on_input(struct avr_t *avr, avr_io_addr_t address, void *context)
{
    (void)avr;
    (void)address;
    (void)context;
    if (passed < sizeof shares) {
        return shares[passed++];
    }
    const int octet = input != NULL ? getc(input) : EOF;
    return octet == EOF ? 0u : (uint8_t)octet;
}

/* Appends a number from the environment to the first octets of the input, with 32 bits. */
static void share(unsigned at, const char *name, unsigned long otherwise)
{
    const char *text = getenv(name);
    const unsigned long number = text != NULL && *text != '\0' ? strtoul(text, NULL, 10) : otherwise;
    for (unsigned n = 0; n < 4u; n++) {
        shares[at + n] = (unsigned char)(number >> 8u * n & 0xFFu);
    }
}

int main(int argc, char **argv)
{
    elf_firmware_t program;
    memset(&program, 0, sizeof program);
    if (argc < 2 || argc > 3 || elf_read_firmware(argv[1], &program) != 0) {
        fprintf(stderr, "usage: avr_simulator PROGRAM.elf [INPUT]\n");
        return WRONG_USE;
    }
    if (argc == 3 && (input = fopen(argv[2], "rb")) == NULL) {
        fprintf(stderr, "avr_simulator: %s cannot be read\n", argv[2]);
        return WRONG_USE;
    }
    const time_t now = time(NULL);
    const struct tm *const day = gmtime(&now);
    const int today = (day->tm_year + 1900) * 10000 + (day->tm_mon + 1) * 100 + day->tm_mday;
    share(0, "LAGLESS_GRID_SEED", (unsigned long)today);
    share(4, "LAGLESS_GRID_SHARE", 1);
    setvbuf(stdout, NULL, _IOLBF, 0);
    avr_t *avr = avr_make_mcu_by_name("atmega2560");
    avr->ramend = 0xFFFF;
    avr->flashend = 0x7FFFF; /* its program counter has 22 bits: 8 M */
    avr_init(avr);
    avr->log = LOG_ERROR;
    avr_load_firmware(avr, &program);
    avr_register_io_write(avr, GPIOR0, on_character, NULL);
    avr_register_io_write(avr, GPIOR1, on_exit_code, NULL);
    avr_register_io_read(avr, GPIOR2, on_input, NULL);

    int state = cpu_Running;
    while (state != cpu_Done && state != cpu_Crashed) {
        state = avr_run(avr);
    }
    fprintf(stderr, "%.1f million cycles\n", (double)avr->cycle / 1e6);
    return exit_code >= 0 ? exit_code : CRASHED;
}
