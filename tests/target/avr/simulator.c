/* An ATmega2560 with external RAM up to 64 K, run by libsimavr: 16-bit int, 32-bit double. Three spare
 * registers are the door to the desk:
 *
 *     GPIOR0 written: a character for standard output
 *     GPIOR1 written: the end; the value is the exit code
 *     GPIOR2 read:    the next octet of the input file; 0 when there is none left
 *
 * usage: avr_simulator PROGRAM.elf [INPUT] */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <simavr/sim_avr.h>
#include <simavr/sim_elf.h>

enum { GPIOR0 = 0x3E, GPIOR1 = 0x4A, GPIOR2 = 0x4B }; /* data addresses */

enum { CRASHED = 99, WRONG_USE = 2 };

static FILE *input;
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
    const int octet = input != NULL ? getc(input) : EOF;
    return octet == EOF ? 0u : (uint8_t)octet;
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
    setvbuf(stdout, NULL, _IOLBF, 0);
    avr_t *avr = avr_make_mcu_by_name("atmega2560");
    avr->ramend = 0xFFFF;
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
