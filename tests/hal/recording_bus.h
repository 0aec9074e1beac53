/* A bus that records the actions of the HAL: every write in order, with its width and the state of EALLOW,
 * every wait, and what happens to the CPU's interrupt masks. It contains a register file in RAM that
 * simulates only the changes that the HAL reads: PLL lock, trip flags, write-one-to-clear flags, running
 * time. host_sim/chip simulates the reaction of the hardware. */
#ifndef TESTS_HAL_RECORDING_BUS_H
#define TESTS_HAL_RECORDING_BUS_H

#include <stdbool.h>
#include <stdint.h>

#include "hal/f28335/bus.h"

#define RECORDING_MAX         512u
#define RECORDING_FLASH_AT    0x328000u /* [words] sector C; sector B follows */
#define RECORDING_FLASH_WORDS 0x8000u
#define RECORDING_API_WORDS   24u
#define RECORDING_API_SCALE   16u /* [words] offset from the head; the pointer to a callback follows */

typedef enum {
    DID_WRITE16,
    DID_WRITE32,
    DID_WAIT,
    DID_ENABLE_GROUP,
    DID_REQUEST_GROUP,
    DID_INTERRUPTS_ON,
    DID_INTERRUPTS_OFF,
    DID_DISABLE_GROUPS,
    DID_CLEAR_PENDING,
    DID_DEBUG_GROUPS,
    DID_DEBUG_ALLOW,
    DID_ERASE,
    DID_PROGRAM,
    DID_COPY_CODE
} did_t;

typedef struct {
    did_t did;
    uint32_t address; /* [words] */
    uint32_t value;   /* written value, cycles of a wait, or number of a group */
    bool allowed;     /* EALLOW was set */
} entry_t;

typedef struct {
    entry_t entry[RECORDING_MAX];
    uint32_t entries;
    uint32_t overflows; /* entries that did not fit in the log */
    uint32_t nested;    /* EALLOW or EDIS without the other in between, and waits between them */
    f28335_t regs;
    bool allowed;
    bool interrupts_on;
    uint16_t groups;              /* bit n - 1: INTn enabled in IER */
    uint16_t debug_groups;        /* bit n - 1: INTn enabled in DBGIER */
    bool debug_allowed;           /* DBGM is clear */
    uint16_t memory[BUS_REGIONS]; /* start of each region of memory */
    uint16_t otp[2];              /* words 0x380083 and 0x380085; all others read as erased */
    uint64_t waited;              /* [cycles] */
    uint64_t lock_cycles;         /* [cycles] from the write of PLLCR to the lock */
    uint64_t pllcr_written;       /* [cycles] value of `waited` at that time */
    bool loses_clock_at_lock;     /* MCLKSTS is set while the PLL locks */
    uint16_t trip_deaf;           /* bit n - 1: ePWMn ignores a forced trip */
    uint16_t trip_again;          /* bit n - 1: ePWMn trips again directly after the clear */
    uint16_t octet[64];           /* received octets of SCI-A, as SCIRXBUF shows them */
    uint32_t octets_came;
    uint32_t octets_taken;
    uint32_t overrun;                           /* the overflow bit of SCIFFRX */
    uint16_t flash[2u * RECORDING_FLASH_WORDS]; /* sectors C and B */
    uint16_t flash_beside;                      /* any other word of the flash, which no access may reach */
    bool flash_broken;                          /* the flash reports a failure and does not erase */
    uint16_t code[RECORDING_API_WORDS];         /* the part of L0-L3 that the flash API uses */
    uint32_t api_words;                         /* length of the flash API; 0 if the build has none */
    uint16_t api_version;
    bus_isr_t function[5]; /* functions given to bus_vector; the vector is 0x300000 + index */
    uint32_t functions;
} bus_recording_t;

extern bus_recording_t rec;

/* Sets the register file to the state after the boot ROM (SPRUFB0, SPRU963): watchdog running, DIVSEL 2,
 * PLL off, prescalers at their reset values. */
void recording_reset(void);

/* Empties the log without a change of the registers. */
void recording_clear_log(void);

/* First entry at or after `from` that writes this register; `entries` if none. */
uint32_t recording_find(uint32_t from, const volatile void *reg);

/* The first entry at or after `from` that writes this value to this register; `entries` if none. */
uint32_t recording_find_value(uint32_t from, const volatile void *reg, uint32_t value);

uint32_t recording_count(const volatile void *reg);
uint32_t recording_address(const volatile void *reg);

/* Fills every control register of ePWM1-3, eQEP1, timer 0 and the ADC with a value, as another program may
 * have left it. */
void recording_soil(void);

/* A word arrives in the receive FIFO. The second function sets the flag that more words arrived than it
 * holds. */
void recording_receive(uint16_t word);
void recording_overrun(void);

/* SYSCLK cycles pass: CPU timer 0 counts down, if it runs. */
void recording_pass(uint32_t cycles);

#endif
