/* State of the virtual F28335. Included by chip.h only. Times called "cycle" count SYSCLK since reset, "tick"
 * 150 MHz. */
#ifndef HOST_SIM_CHIP_CHIP_STATE_H
#define HOST_SIM_CHIP_CHIP_STATE_H

#define CHIP_EPWMS          6u
#define CHIP_LEGS           3u /* of an inverter: on ePWM1..3 or on ePWM4..6 */
#define CHIP_EQEPS          2u
#define CHIP_REPORTS        16u
#define CHIP_MEMORY_REGIONS 3u
#define CHIP_MEMORY_WORDS   128u
#define CHIP_LINE_FRAMES    128u  /* on the serial line towards the chip */
#define CHIP_LINE_SENT      512u  /* octets that have not been read outside yet */
#define CHIP_FLASH_PAGES    2u    /* sectors that the drive writes itself: C and B */
#define CHIP_FLASH_KEPT     2048u /* [words] of each that can be programmed */
#define CHIP_I2C_PAGE       128u  /* [octets] largest page of a memory on the I2C bus */
#define CHIP_I2C_KEPT       4096u /* [octets] of it that can be written */

/* One ePWM module. */
typedef struct {
    uint64_t anchor;     /* [cycle] the counter was `count` here */
    uint64_t count_next; /* [cycle] next count at which something happens */
    uint64_t sync_due;   /* [cycle] synchronisation pulse arrives */
    uint64_t red_due;    /* [cycle] rising edge leaves the dead band */
    uint64_t fed_due;    /* [cycle] falling edge leaves the dead band */
    uint64_t cau;        /* [cycle] plain carrier: the counter passes CMPA going up in this period */
    uint64_t cad;        /* [cycle] plain carrier: and coming down */
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
    uint32_t cbc;        /* [-] cycle-by-cycle trip holds the outputs */
    uint32_t running;    /* [-] TBCLK is there */
    uint32_t divider;    /* [-] SYSCLK cycles per TBCLK */
    uint32_t overflow;   /* [-] TBSTS CTRMAX latch */
} chip_epwm_t;

/* Three legs in step and plainly set up: one description for all. */
typedef struct {
    uint64_t zero;      /* [cycle] begin of this carrier period */
    uint64_t end;       /* [cycle] begin of the next one */
    uint64_t soc;       /* [cycle] start of conversion within this period */
    uint32_t active;    /* [-] */
    uint32_t lazy;      /* [-] the edges of this period are not reported: the legs have the state at `zero` */
    uint32_t half;      /* [-] TBPRD */
    uint32_t soc_event; /* [-] ET_... of SOCA, 0 = none */
    uint32_t polarity;  /* [-] DBCTL POLSEL if averaged mode may describe the legs, 0 = it may not */
    uint32_t first;     /* [-] module of the first leg: 0 or 3 */
    uint32_t members;   /* [-] bit m = module m counts in step */
    uint32_t soc_from;  /* [-] module whose SOCA starts the conversion */
    uint32_t up_level;  /* [-] what output A becomes when the counter passes CMPA going up */
    uint32_t spare;     /* fills the struct to a multiple of 64 bits */
} chip_carrier_t;

/* Twelve gate pins, bit 2(n-1) = EPWMnA, bit 2(n-1)+1 = EPWMnB. */
typedef struct {
    uint32_t raw;          /* [-] out of the dead band, polarity applied */
    uint32_t muxed;        /* [-] pin belongs to its ePWM */
    uint32_t forced;       /* [-] trip zone overrides */
    uint32_t forced_level; /* [-] */
    uint32_t floating;     /* [-] trip zone makes it high-impedance */
    uint32_t gpio_driven;  /* [-] pin is a plain output */
    uint32_t gpio_level;   /* [-] */
    uint32_t level;        /* [-] as last reported */
    uint32_t driven;       /* [-] as last reported */
    uint32_t hidden;       /* [-] an average has been reported to the world since */
    uint32_t first;        /* [-] module of the first leg: 3 if only pins of ePWM4..6 are connected, else 0 */
    uint32_t spare;        /* fills the struct to a multiple of 64 bits */
} chip_pins_t;

typedef struct {
    uint64_t next;       /* [cycle] end of the next sample window or of the sequence; CHIP_NEVER: idle */
    uint64_t ready;      /* [tick] power-up over */
    uint64_t first;      /* [cycle] first sample window of the running sequence ends */
    uint32_t result[16]; /* [-] codes of the running sequence, in order */
    int32_t stuck[16];   /* [-] injected code per channel, -1 = none */
    uint32_t held;       /* [-] how many codes are in `result` */
    uint32_t published;  /* [-] how many of them the registers show */
    uint32_t slot;       /* [-] result register of the first */
    uint32_t pair;       /* [-] simultaneous, of the running sequence */
    uint32_t spacing;    /* [cycles] between sample windows, of the running sequence */
    uint32_t states;     /* [-] states of the sequencer, of the running sequence */
    uint32_t adjust;     /* [-] results are not the plain ones, of the running sequence */
    uint32_t missing;    /* [-] injected: number of coming starts of conversion that are lost */
    uint32_t pending;    /* [-] one more start of conversion waits */
    uint32_t state;      /* [-] SEQ1_STATE: next conversion */
    uint32_t remaining;  /* [-] conversions to hold yet */
    uint32_t clock;      /* [-] SYSCLK cycles per ADCCLK, of the running sequence */
    uint32_t powered;    /* [-] results are good, of the running sequence */
    uint32_t second;     /* [-] interrupt mode 1: this end of sequence counts */
} chip_adc_t;

typedef struct {
    int64_t position;   /* [counts] the world's, at `cycle` */
    uint64_t cycle;     /* [cycle] last look at the pins */
    uint64_t unit_next; /* [cycle] unit time-out */
    uint32_t counting;  /* [-] clock, QPEN and pins are on */
    uint32_t direction; /* [-] QDF */
    uint32_t held;      /* [-] a debugger's halt has stopped the position counter */
    uint32_t unit_held; /* [-] and the unit timer */
} chip_eqep_t;

typedef struct {
    uint64_t reload;  /* [cycle] TIM goes from 0 to PRD; meaningless while stopped */
    uint64_t left;    /* [cycles] to the reload, while stopped */
    uint32_t running; /* [-] */
    uint32_t step;    /* [-] SYSCLK cycles per count */
} chip_timer_t;

typedef struct {
    uint64_t start; /* [tick] WDCNTR was 0 here */
    uint64_t next;  /* [tick] overflow */
    uint32_t key;   /* [-] 0x55 has been seen */
    uint32_t off;   /* [-] WDDIS */
} chip_watchdog_t;

/* Bits on the line towards the chip, lowest first. */
typedef struct {
    uint64_t start;  /* [tick] */
    uint32_t levels; /* [-] 1 high */
    uint32_t bits;   /* [-] the last one is high */
} chip_frame_t;

typedef struct {
    uint64_t next;           /* [tick] a frame will be complete that may raise the interrupt */
    uint64_t looks_from;     /* [tick] the receiver has dealt with the line up to here */
    uint64_t sent_at;        /* [tick] the octet in the shift register is out */
    uint32_t line_baud;      /* [bit/s] of who sends to the chip; 0: as the chip itself */
    uint32_t line_first;     /* [-] in `line` */
    uint32_t line_count;     /* [-] */
    uint32_t low;            /* [-] a stop bit was missing, and the line has not been seen high since */
    uint32_t received;       /* [-] octets in `in` */
    uint32_t received_first; /* [-] */
    uint32_t waiting;        /* [-] octets in `out` */
    uint32_t waiting_first;  /* [-] */
    uint32_t sending;        /* [-] there is an octet in the shift register: */
    uint32_t shifted;        /* [-] this one */
    uint32_t sent_first;     /* [-] in `sent` */
    uint32_t sent_count;     /* [-] */
    uint16_t in[16];         /* [-] FIFO as SCIRXBUF shows it */
    uint16_t out[16];        /* [-] FIFO */
    chip_frame_t line[CHIP_LINE_FRAMES];
    uint8_t sent[CHIP_LINE_SENT];
} chip_sci_t;

/* The sectors that the drive writes itself. A page is erased in two passes, first all words to 0, then all to
 * 0xFFFF, a word at a time; the part after the stored words is erased in one step. */
typedef struct {
    uint64_t busy_until; /* [tick] the last operation took until here */
    uint32_t operations; /* [-] words touched since power-on */
    uint32_t cut_after;  /* [-] operations until the power is cut, if it is to be */
    uint32_t cut;        /* [-] it is to be */
    uint32_t spare;      /* fills the struct to a multiple of 64 bits */
    uint16_t word[CHIP_FLASH_PAGES][CHIP_FLASH_KEPT + 4u]; /* the last four: the part after the stored words,
                                                              in the first of them */
} chip_flash_t;

/* A memory on the I2C bus: EEPROM with pages, or FRAM. */
typedef struct {
    uint64_t busy_until;                /* [tick] it writes, and acknowledges nothing */
    uint32_t attached;                  /* [-] there is one */
    uint32_t address;                   /* [-] 7 bits */
    uint32_t page;                      /* [octets] 0: none */
    uint32_t write_ticks;               /* [ticks] of a page */
    uint32_t state;                     /* [-] what its next octet is: i2c_memory.c */
    uint32_t place;                     /* [octets] where the next octet goes, or comes from */
    uint32_t buffered;                  /* [-] 1: octets wait for STOP */
    uint32_t held;                      /* [-] clock pulses until it releases the data line */
    uint32_t broken;                    /* [-] injected: it acknowledges and keeps its content */
    uint32_t sent[CHIP_I2C_PAGE / 32u]; /* [-] octets of the page that were sent, a bit each */
    uint32_t spare;                     /* fills the struct to a multiple of 64 bits */
    uint8_t buffer[CHIP_I2C_PAGE];
    uint8_t octet[CHIP_I2C_KEPT];
} chip_i2c_memory_t;

typedef struct {
    uint64_t due;           /* [tick] what is under way is complete */
    uint32_t phase;         /* [-] of the transfer: i2c.c */
    uint32_t left;          /* [octets] of its count */
    uint32_t shifted;       /* [-] octet that is being sent */
    uint32_t waiting;       /* [-] octets in `out` */
    uint32_t waiting_first; /* [-] */
    uint32_t received;      /* [-] octets in `in` */
    uint32_t clock_low;     /* [-] the clock line is pulled low as a plain pin */
    uint32_t spare;         /* fills the struct to a multiple of 64 bits */
    uint16_t out[16];       /* [-] FIFO */
    uint16_t in[16];        /* [-] FIFO, the oldest first */
    chip_i2c_memory_t memory;
} chip_i2c_t;

typedef struct {
    uint64_t tick;           /* [tick] SYSCLK cycle `cycle` began here */
    uint64_t cycle;          /* [cycle] */
    uint64_t locked;         /* [tick] PLL locks; CHIP_NEVER: nothing under way */
    uint32_t ticks;          /* [-] `ticks` ticks are `cycles` SYSCLK cycles */
    uint32_t cycles;         /* [-] */
    uint32_t crystal_ticks;  /* [-] `crystal_ticks` ticks are `crystal_cycles` cycles of the crystal */
    uint32_t crystal_cycles; /* [-] */
} chip_clock_t;

typedef struct {
    uint64_t busy_until;     /* [tick] sections with INTM set took until here */
    uint32_t interrupts_off; /* [-] INTM */
    uint32_t ier;            /* [-] */
    uint32_t ifr;            /* [-] */
    uint32_t groups;         /* [-] PIE groups with an enabled flag */
    uint32_t allow;          /* [-] EALLOW */
    uint32_t halted;         /* [-] no software runs */
    uint32_t delay;          /* [ticks] injected interrupt delay */
    uint32_t resets;         /* [-] watchdog resets so far */
    uint32_t dbgm;           /* [-] DBGM: a debugger may not look while the CPU runs */
    uint32_t dbgier;         /* [-] interrupts that are served in a real-time halt */
    uint32_t asked;          /* [-] software requested the last reset by a wrong WDCHK */
    uint32_t section;        /* [-] 1: INTM was set by software, not by an interrupt: its end takes time */
} chip_cpu_t;

/* A debugger's halt. */
typedef struct {
    uint64_t since;            /* [tick] beginning of the halt */
    uint64_t cycle;            /* [cycle] the same */
    uint64_t stop[CHIP_EPWMS]; /* [cycle] the counter of a module stops here */
    uint32_t halted;           /* [-] */
    uint32_t realtime;         /* [-] a halt stops the background only */
    uint32_t frozen;           /* [-] bit m = counter of module m stands */
    uint32_t ending;           /* [-] bit m = it will, at the end of its cycle */
    uint32_t timers;           /* [-] bit n = CPU timer n stands */
    uint32_t adc;              /* [-] the sequencer stands in the middle of a sequence */
} chip_debug_t;

typedef struct {
    f28335_t registers;     /* what firmware sees at F28335_BASE */
    uint64_t tick;          /* [tick] now */
    uint64_t next[5];       /* [tick] earliest event of each source: ePWM, eQEP, ADC, CPU, the rare ones */
    uint64_t limit;         /* [tick] a part may run ahead alone up to here */
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
