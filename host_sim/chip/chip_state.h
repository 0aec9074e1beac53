/* State of the virtual F28335. Only chip.h includes it. A time in cycles counts cycles of SYSCLK since the
 * reset; a time in ticks counts periods of 150 MHz. */
#ifndef HOST_SIM_CHIP_CHIP_STATE_H
#define HOST_SIM_CHIP_CHIP_STATE_H

#define CHIP_EPWMS          6u
#define CHIP_LEGS           3u /* of an inverter: on ePWM1..3 or on ePWM4..6 */
#define CHIP_EQEPS          2u
#define CHIP_REPORTS        16u
#define CHIP_MEMORY_REGIONS 3u
#define CHIP_MEMORY_WORDS   128u
#define CHIP_LINE_FRAMES    128u  /* frames on the serial line that the chip will receive */
#define CHIP_LINE_SENT      512u  /* octets that were sent and have not been read outside yet */
#define CHIP_FLASH_PAGES    2u    /* sectors that the drive writes: C and B */
#define CHIP_FLASH_KEPT     2048u /* [words] that can be programmed in each of them */
#define CHIP_I2C_PAGE       128u  /* [octets] largest page of a memory on the I2C bus */
#define CHIP_I2C_KEPT       4096u /* [octets] that can be written in such a memory */

/* One ePWM module. */
typedef struct {
    uint64_t anchor;     /* [cycle] the counter was `count` here */
    uint64_t count_next; /* [cycle] next count at which something happens */
    uint64_t sync_due;   /* [cycle] next synchronisation pulse */
    uint64_t red_due;    /* [cycle] rising edge leaves the dead band */
    uint64_t fed_due;    /* [cycle] falling edge leaves the dead band */
    uint64_t cau;        /* [cycle] with carrier.c: the counter passes CMPA upwards in this period */
    uint64_t cad;        /* [cycle] with carrier.c: the counter passes CMPA downwards */
    uint64_t next;       /* [cycle] earliest of the above */
    uint32_t count;      /* [-] TBCTR at anchor */
    uint32_t up;         /* [-] direction at anchor */
    uint32_t period;     /* [-] active TBPRD */
    uint32_t cmpa;       /* [-] active CMPA */
    uint32_t cmpb;       /* [-] active CMPB */
    uint32_t force;      /* [-] active AQCSFRC */
    uint32_t a;          /* [-] action qualifier outputs */
    uint32_t b;          /* [-] */
    uint32_t red_in;     /* [-] inputs and outputs of the dead band, before polarity */
    uint32_t fed_in;     /* [-] */
    uint32_t red;        /* [-] */
    uint32_t fed;        /* [-] */
    uint32_t cbc;        /* [-] 1: a cycle-by-cycle trip determines the outputs */
    uint32_t running;    /* [-] 1: the counter has a clock (TBCLK) */
    uint32_t divider;    /* [-] SYSCLK cycles per TBCLK */
    uint32_t overflow;   /* [-] TBSTS CTRMAX latch */
} chip_epwm_t;

/* Three legs whose counters are equal and that have the usual set-up: one description for all (carrier.c). */
typedef struct {
    uint64_t zero;   /* [cycle] beginning of this carrier period */
    uint64_t end;    /* [cycle] beginning of the next carrier period */
    uint64_t soc;    /* [cycle] start of conversion within this period */
    uint32_t active; /* [-] */
    uint32_t lazy;   /* [-] 1: the edges of this period are not reported: the legs have the state at `zero` */
    uint32_t half;   /* [-] TBPRD */
    uint32_t soc_event; /* [-] ET_... of SOCA, 0 = none */
    uint32_t polarity;  /* [-] DBCTL POLSEL; 0: averaged mode cannot be used for these legs */
    uint32_t first;     /* [-] module of the first leg: 0 or 3 */
    uint32_t members;   /* [-] bit m: module m is one of the legs */
    uint32_t soc_from;  /* [-] module with the SOCA that starts the conversion */
    uint32_t up_level;  /* [-] level of output A after the counter has passed CMPA upwards */
    uint32_t spare;     /* fills the struct to a multiple of 64 bits */
} chip_carrier_t;

/* Twelve gate pins, bit 2(n-1) = EPWMnA, bit 2(n-1)+1 = EPWMnB. */
typedef struct {
    uint32_t raw;          /* [-] output of the dead band, with polarity */
    uint32_t muxed;        /* [-] the multiplexer connects the pin to its ePWM */
    uint32_t forced;       /* [-] the trip zone determines the level */
    uint32_t forced_level; /* [-] */
    uint32_t floating;     /* [-] the trip zone has made the pin high-impedance */
    uint32_t gpio_driven;  /* [-] the pin is a GPIO output */
    uint32_t gpio_level;   /* [-] */
    uint32_t level;        /* [-] as last reported */
    uint32_t driven;       /* [-] as last reported */
    uint32_t hidden;       /* [-] 1: an average has been reported to the world since then */
    uint32_t first;        /* [-] module of the first leg: 3 if only pins of ePWM4..6 are connected, else 0 */
    uint32_t spare;        /* fills the struct to a multiple of 64 bits */
} chip_pins_t;

typedef struct {
    uint64_t next;       /* [cycle] end of the next sample window or of the sequence; CHIP_NEVER: idle */
    uint64_t ready;      /* [tick] end of the power-up */
    uint64_t first;      /* [cycle] end of the first sample window of the running sequence */
    uint32_t result[16]; /* [-] codes of the running sequence, in order */
    int32_t stuck[16];   /* [-] injected code of each channel; -1: none */
    uint32_t held;       /* [-] number of codes in `result` */
    uint32_t published;  /* [-] number of these codes that are in the registers */
    uint32_t slot;       /* [-] result register of the first code */
    uint32_t pair;       /* [-] 1: simultaneous sampling, of the running sequence */
    uint32_t spacing;    /* [cycles] between sample windows, of the running sequence */
    uint32_t states;     /* [-] states of the sequencer, of the running sequence */
    uint32_t adjust;     /* [-] 1: results need a correction, of the running sequence */
    uint32_t missing;    /* [-] injected: number of coming starts of conversion that are lost */
    uint32_t pending;    /* [-] 1: another start of conversion waits */
    uint32_t state;      /* [-] SEQ1_STATE: next conversion */
    uint32_t remaining;  /* [-] conversions of the sequence that are still to sample */
    uint32_t clock;      /* [-] SYSCLK cycles per ADCCLK, of the running sequence */
    uint32_t powered;    /* [-] 1: the converter was powered up, of the running sequence */
    uint32_t second;     /* [-] with interrupt mode 1: this end of sequence causes the interrupt */
} chip_adc_t;

typedef struct {
    int64_t position;   /* [counts] position in the world at `cycle` */
    uint64_t cycle;     /* [cycle] time at which the pins were last read */
    uint64_t unit_next; /* [cycle] next unit time-out */
    uint32_t counting;  /* [-] clock, QPEN and pins are on */
    uint32_t direction; /* [-] QDF */
    uint32_t held;      /* [-] a debugger's halt has stopped the position counter */
    uint32_t unit_held; /* [-] a debugger's halt has stopped the unit timer */
} chip_eqep_t;

typedef struct {
    uint64_t reload;  /* [cycle] TIM changes from 0 to PRD; not used while stopped */
    uint64_t left;    /* [cycles] to the reload, while stopped */
    uint32_t running; /* [-] */
    uint32_t step;    /* [-] SYSCLK cycles per count */
} chip_timer_t;

typedef struct {
    uint64_t start; /* [tick] at this time WDCNTR was 0 */
    uint64_t next;  /* [tick] overflow */
    uint32_t key;   /* [-] 1: 0x55 was written last */
    uint32_t off;   /* [-] WDDIS */
} chip_watchdog_t;

/* Bits on the serial line that the chip receives, lowest first. */
typedef struct {
    uint64_t start;  /* [tick] */
    uint32_t levels; /* [-] 1: high */
    uint32_t bits;   /* [-] the last one is high */
} chip_frame_t;

typedef struct {
    uint64_t next;           /* [tick] end of the next frame that may cause the interrupt */
    uint64_t looks_from;     /* [tick] the receiver has processed the line until this time */
    uint64_t sent_at;        /* [tick] end of the octet in the shift register */
    uint32_t line_baud;      /* [bit/s] of the other end; 0: that of the chip */
    uint32_t line_first;     /* [-] in `line` */
    uint32_t line_count;     /* [-] */
    uint32_t low;            /* [-] 1: a stop bit was missing, and the line has been low since then */
    uint32_t received;       /* [-] octets in `in` */
    uint32_t received_first; /* [-] */
    uint32_t waiting;        /* [-] octets in `out` */
    uint32_t waiting_first;  /* [-] */
    uint32_t sending;        /* [-] 1: there is an octet in the shift register */
    uint32_t shifted;        /* [-] this octet */
    uint32_t sent_first;     /* [-] in `sent` */
    uint32_t sent_count;     /* [-] */
    uint16_t in[16];         /* [-] FIFO as SCIRXBUF shows it */
    uint16_t out[16];        /* [-] FIFO */
    chip_frame_t line[CHIP_LINE_FRAMES];
    uint8_t sent[CHIP_LINE_SENT];
} chip_sci_t;

/* The sectors that the drive writes. A page is erased word by word in two passes: all words are set to 0,
 * then to 0xFFFF. The part after the stored words is erased in one step. */
typedef struct {
    uint64_t busy_until; /* [tick] end of the last operation */
    uint32_t operations; /* [-] operations since power-on, one a word */
    uint32_t cut_after;  /* [-] operations until the power is cut, with `cut` */
    uint32_t cut;        /* [-] 1: the power will be cut */
    uint32_t spare;      /* fills the struct to a multiple of 64 bits */
    uint16_t word[CHIP_FLASH_PAGES][CHIP_FLASH_KEPT + 4u]; /* the last four: for the part after the stored
                                                              words, which is kept in the first of them */
} chip_flash_t;

/* A memory on the I2C bus: EEPROM with pages, or FRAM. */
typedef struct {
    uint64_t busy_until;                /* [tick] until this time it writes and does not acknowledge */
    uint32_t attached;                  /* [-] 1: the board has this memory */
    uint32_t address;                   /* [-] 7 bits */
    uint32_t page;                      /* [octets] size of a page; 0: no pages */
    uint32_t write_ticks;               /* [ticks] time for writing a page */
    uint32_t state;                     /* [-] meaning of the next octet: i2c_memory.c */
    uint32_t place;                     /* [octets] address of the next octet */
    uint32_t buffered;                  /* [-] 1: octets in `buffer`, which are written after STOP */
    uint32_t held;                      /* [-] clock pulses after which it releases the data line */
    uint32_t broken;                    /* [-] injected fault: it acknowledges, but does not write */
    uint32_t sent[CHIP_I2C_PAGE / 32u]; /* [-] one bit for each octet of the page: 1: it was sent */
    uint32_t spare;                     /* fills the struct to a multiple of 64 bits */
    uint8_t buffer[CHIP_I2C_PAGE];
    uint8_t octet[CHIP_I2C_KEPT];
} chip_i2c_memory_t;

typedef struct {
    uint64_t due;           /* [tick] end of the present step of the transfer */
    uint32_t phase;         /* [-] phase of the transfer: i2c.c */
    uint32_t left;          /* [octets] that are still to transfer */
    uint32_t shifted;       /* [-] octet that is being sent */
    uint32_t waiting;       /* [-] octets in `out` */
    uint32_t waiting_first; /* [-] */
    uint32_t received;      /* [-] octets in `in` */
    uint32_t clock_low;     /* [-] 1: the clock line is low as a GPIO output */
    uint32_t spare;         /* fills the struct to a multiple of 64 bits */
    uint16_t out[16];       /* [-] FIFO */
    uint16_t in[16];        /* [-] FIFO, the oldest first */
    chip_i2c_memory_t memory;
} chip_i2c_t;

typedef struct {
    uint64_t tick;           /* [tick] beginning of the SYSCLK cycle `cycle` */
    uint64_t cycle;          /* [cycle] */
    uint64_t locked;         /* [tick] time at which the PLL will lock; CHIP_NEVER: it is not locking */
    uint32_t ticks;          /* [ticks] duration of `cycles` SYSCLK cycles */
    uint32_t cycles;         /* [-] */
    uint32_t crystal_ticks;  /* [ticks] duration of `crystal_cycles` cycles of the crystal */
    uint32_t crystal_cycles; /* [-] */
} chip_clock_t;

typedef struct {
    uint64_t busy_until;     /* [tick] end of the last section with INTM set */
    uint32_t interrupts_off; /* [-] INTM */
    uint32_t ier;            /* [-] */
    uint32_t ifr;            /* [-] */
    uint32_t groups;         /* [-] PIE groups with a flag that is set and enabled */
    uint32_t allow;          /* [-] EALLOW */
    uint32_t halted;         /* [-] 1: no software runs */
    uint32_t delay;          /* [ticks] injected interrupt delay */
    uint32_t resets;         /* [-] watchdog resets so far */
    uint32_t dbgm;           /* [-] DBGM: 1: a debugger has no access while the CPU runs */
    uint32_t dbgier;         /* [-] interrupts that are served in a real-time halt */
    uint32_t asked;          /* [-] 1: software requested the last reset by a wrong WDCHK */
    uint32_t section; /* [-] 1: INTM was set by software, not by an interrupt; the section then takes time */
} chip_cpu_t;

/* A debugger's halt. */
typedef struct {
    uint64_t since;            /* [tick] beginning of the halt */
    uint64_t cycle;            /* [cycle] the same */
    uint64_t stop[CHIP_EPWMS]; /* [cycle] time at which the counter of a module stops */
    uint32_t halted;           /* [-] */
    uint32_t realtime;         /* [-] 1: a halt stops only the background */
    uint32_t frozen;           /* [-] bit m: the counter of module m is stopped */
    uint32_t ending;           /* [-] bit m: the counter of module m will stop at the end of its cycle */
    uint32_t timers;           /* [-] bit n: CPU timer n is stopped */
    uint32_t adc;              /* [-] 1: the sequencer is stopped within a sequence */
} chip_debug_t;

typedef struct {
    f28335_t registers;     /* the registers that the firmware accesses at F28335_BASE */
    uint64_t tick;          /* [tick] now */
    uint64_t next[5];       /* [tick] earliest event of each source_t: ePWM, eQEP, ADC, CPU, rare ones */
    uint64_t limit;         /* [tick] a part may handle its own events up to here in one call */
    uint64_t timer_next;    /* [tick] earliest timer reload that interrupts */
    uint64_t epwm_next;     /* [cycle] same as next[0] */
    uint64_t carrier_tick;  /* [tick] last zero of the first leg's module */
    uint64_t carrier_cycle; /* [cycle] the same */
    uint64_t sample_tick;   /* [tick] last entry of SEQ1INT */
    chip_clock_t clock;
    chip_epwm_t epwm[CHIP_EPWMS];
    chip_carrier_t carrier;
    chip_adc_t adc;
    chip_eqep_t eqep[CHIP_EQEPS];
    chip_timer_t timer[3];
    chip_watchdog_t watchdog;
    chip_cpu_t cpu;
    chip_debug_t debug;
    chip_pins_t pins;
    chip_sci_t sci;
    chip_flash_t flash;
    chip_i2c_t i2c;
    uint32_t gpio_input[3];                   /* [-] levels that the board applies to the pins */
    uint32_t gpio_latch[3];                   /* [-] output latches */
    uint32_t averaged;                        /* [-] */
    uint32_t report_total;                    /* [-] */
    uint32_t report_count[CHIP_REPORT_KINDS]; /* [-] */
    uint32_t entries[128];                    /* [-] interrupts taken per vector */
    uint32_t tripped;                         /* [-] legs that their trip zone holds off, as last reported */
    uint16_t memory[CHIP_MEMORY_REGIONS][CHIP_MEMORY_WORDS]; /* flash, code in RAM, end of the stack */
    chip_report_t reports[CHIP_REPORTS];                     /* ring, last one at (report_total - 1) mod 16 */
} chip_t;

#endif
