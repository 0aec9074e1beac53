/* Registers of the TMS320F28335 that this drive uses: layout, addresses, fields.
 *
 * Names and offsets are TI's (data manual SPRS439, peripheral guides SPRUFB0, SPRUG04, SPRU812, SPRUG05,
 * SPRUFZ5, SPRUG03). All addresses count 16-bit words. Every struct consists of words, so that the same
 * source describes silicon and the copy in RAM that the virtual chip uses. Each offset is checked at compile
 * time below.
 *
 * Registers are reached through F28335_BASE: fixed on silicon, one pointer on the host (bus.h). They are
 * `const volatile`, because reading is a plain load and writing uses the functions of bus.h. */
#ifndef HAL_F28335_REGISTERS_H
#define HAL_F28335_REGISTERS_H

#include <stddef.h>
#include <stdint.h>

/* ---- CPU timer: SPRUFB0 ch. 3 ---- */
typedef struct {
    uint32_t TIM; /* counts down */
    uint32_t PRD;
    uint16_t TCR;
    uint16_t reserved5;
    uint16_t TPR;
    uint16_t TPRH;
} cpu_timer_regs_t;

#define TCR_TSS  (1u << 4)  /* 1 = stopped */
#define TCR_TRB  (1u << 5)  /* reload */
#define TCR_SOFT (1u << 10) /* debug halt: 1 and FREE 0 = stop at the next reload */
#define TCR_FREE (1u << 11) /* debug halt: run on */
#define TCR_TIE  (1u << 14)
#define TCR_TIF  (1u << 15) /* write one to clear */

/* ---- Flash control: SPRUFB0 ch. 1 (EALLOW) ---- */
typedef struct {
    uint16_t FOPT;
    uint16_t reserved1;
    uint16_t FPWR;
    uint16_t FSTATUS;
    uint16_t FSTDBYWAIT;
    uint16_t FACTIVEWAIT;
    uint16_t FBANKWAIT; /* PAGEWAIT[11:8] RANDWAIT[3:0] */
    uint16_t FOTPWAIT;
} flash_regs_t;

#define FOPT_ENPIPE (1u << 0)

/* ---- PIE: SPRUFB0 ch. 6 ---- */
typedef struct {
    uint16_t IER;
    uint16_t IFR;
} pie_group_t;

typedef struct {
    uint16_t PIECTRL; /* ENPIE 0, last vector fetched [15:1] */
    uint16_t PIEACK;  /* write one to clear */
    pie_group_t group[12];
} pie_regs_t;

#define PIECTRL_ENPIE (1u << 0)

/* 128 vectors of 32 bits (EALLOW); INTx.y is vector[32 + 8 * (x - 1) + (y - 1)]. */
typedef struct {
    uint32_t vector[128];
} pie_vectors_t;

#define PIE_VECTOR(x, y) (32u + 8u * ((x)-1u) + ((y)-1u))
#define PIE_SEQ1INT      PIE_VECTOR(1u, 1u)
#define PIE_EPWM_TZ(n)   PIE_VECTOR(2u, n) /* n = 1..6 */
#define PIE_EPWM1_TZ     PIE_EPWM_TZ(1u)
#define PIE_SCIRXINTA    PIE_VECTOR(9u, 1u)

/* ---- System control: SPRUFB0 ch. 5 (EALLOW) ---- */
typedef struct {
    uint16_t reserved00;
    uint16_t PLLSTS; /* 0x7011 */
    uint16_t reserved02[8];
    uint16_t HISPCP;  /* 0x701A */
    uint16_t LOSPCP;  /* 0x701B */
    uint16_t PCLKCR0; /* 0x701C */
    uint16_t PCLKCR1; /* 0x701D */
    uint16_t LPMCR0;  /* 0x701E */
    uint16_t reserved0F;
    uint16_t PCLKCR3; /* 0x7020 */
    uint16_t PLLCR;   /* 0x7021 */
    uint16_t SCSR;    /* 0x7022 */
    uint16_t WDCNTR;  /* 0x7023 */
    uint16_t reserved14;
    uint16_t WDKEY; /* 0x7025 */
    uint16_t reserved16[3];
    uint16_t WDCR; /* 0x7029 */
    uint16_t reserved1A[4];
    uint16_t MAPCNF; /* 0x702E */
    uint16_t reserved1F;
} sysctrl_regs_t;

#define PLLSTS_PLLLOCKS   (1u << 0)
#define PLLSTS_PLLOFF     (1u << 2)
#define PLLSTS_MCLKSTS    (1u << 3) /* missing clock detected */
#define PLLSTS_MCLKCLR    (1u << 4)
#define PLLSTS_OSCOFF     (1u << 5)
#define PLLSTS_MCLKOFF    (1u << 6)
#define PLLSTS_DIVSEL(n)  ((uint16_t)((n) << 7)) /* 0, 1 = /4; 2 = /2; 3 = /1 */
#define PLLSTS_DIVSEL_ALL (3u << 7)
#define PCLKCR0_TBCLKSYNC (1u << 2)
#define PCLKCR0_ADC       (1u << 3)
#define PCLKCR0_I2CA      (1u << 4)
#define PCLKCR0_SCIA      (1u << 10)
#define PCLKCR1_EPWM1     (1u << 0)
#define PCLKCR1_EPWM2     (1u << 1)
#define PCLKCR1_EPWM3     (1u << 2)
#define PCLKCR1_EPWM4     (1u << 3)
#define PCLKCR1_EPWM5     (1u << 4)
#define PCLKCR1_EPWM6     (1u << 5)
#define PCLKCR1_EQEP1     (1u << 14)
#define PCLKCR1_EQEP2     (1u << 15)
#define PCLKCR3_TIMERS    (7u << 8)
#define PCLKCR3_GPIOIN    (1u << 13)
#define SCSR_WDOVERRIDE   (1u << 0)
#define SCSR_WDENINT      (1u << 1)
#define WDCR_WDPS(n)      ((uint16_t)(n)) /* 0, 1 = /1; n = /2^(n-1) */
#define WDCR_WDCHK        (5u << 3)       /* must be written 101 every time */
#define WDCR_WDCHK_ALL    (7u << 3)
#define WDCR_WDDIS        (1u << 6)
#define WDCR_WDFLAG       (1u << 7) /* the last reset came from the watchdog; write one to clear */
#define WDKEY_FIRST       0x55u
#define WDKEY_SECOND      0xAAu

/* ---- GPIO: SPRUFB0 ch. 4 (control EALLOW) ---- */
typedef struct {
    uint32_t CTRL;
    uint32_t QSEL1;
    uint32_t QSEL2;
    uint32_t MUX1;
    uint32_t MUX2;
    uint32_t DIR; /* 1 = output */
    uint32_t PUD; /* 1 = pull-up off */
    uint16_t reserved0E[2];
} gpio_control_regs_t;

typedef struct {
    uint32_t DAT;
    uint32_t SET;
    uint32_t CLEAR;
    uint32_t TOGGLE;
} gpio_data_regs_t;

/* Two bits per pin in MUX1/2 and QSEL1/2, pins 0..15 in the first register. */
#define GPIO_FIELD(pin, value) ((uint32_t)(value) << (2u * ((pin)&15u)))
#define GPIO_PIN(pin)          (UINT32_C(1) << ((pin)&31u))
#define GPIO_QSEL_ASYNC        3u

/* ---- ePWM: SPRUG04 ---- */
typedef struct {
    uint16_t TBCTL;   /* 00 */
    uint16_t TBSTS;   /* 01 */
    uint16_t TBPHSHR; /* 02 */
    uint16_t TBPHS;   /* 03 */
    uint16_t TBCTR;   /* 04 */
    uint16_t TBPRD;   /* 05 */
    uint16_t reserved06;
    uint16_t CMPCTL;  /* 07 */
    uint16_t CMPAHR;  /* 08 */
    uint16_t CMPA;    /* 09 */
    uint16_t CMPB;    /* 0A */
    uint16_t AQCTLA;  /* 0B */
    uint16_t AQCTLB;  /* 0C */
    uint16_t AQSFRC;  /* 0D */
    uint16_t AQCSFRC; /* 0E */
    uint16_t DBCTL;   /* 0F */
    uint16_t DBRED;   /* 10, no shadow, 10 bits */
    uint16_t DBFED;   /* 11 */
    uint16_t TZSEL;   /* 12 EALLOW */
    uint16_t reserved13;
    uint16_t TZCTL;  /* 14 EALLOW */
    uint16_t TZEINT; /* 15 EALLOW */
    uint16_t TZFLG;  /* 16 read only */
    uint16_t TZCLR;  /* 17 EALLOW, write one to clear */
    uint16_t TZFRC;  /* 18 EALLOW */
    uint16_t ETSEL;  /* 19 */
    uint16_t ETPS;   /* 1A */
    uint16_t ETFLG;  /* 1B */
    uint16_t ETCLR;  /* 1C write one to clear */
    uint16_t ETFRC;  /* 1D */
    uint16_t PCCTL;  /* 1E */
    uint16_t reserved1F;
    uint16_t HRCNFG; /* 20 EALLOW */
    uint16_t reserved21[31];
} epwm_regs_t;

#define TBCTL_CTRMODE(n)   ((uint16_t)(n)) /* 0 up, 1 down, 2 up-down, 3 stop */
#define TBCTL_UPDOWN       2u
#define TBCTL_PHSEN        (1u << 2)
#define TBCTL_PRDLD        (1u << 3)              /* 1 = TBPRD without shadow */
#define TBCTL_SYNCOSEL(n)  ((uint16_t)((n) << 4)) /* 0 pass SYNCI, 1 CTR=0, 2 CTR=CMPB, 3 off */
#define TBCTL_SWFSYNC      (1u << 6)
#define TBCTL_HSPCLKDIV(n) ((uint16_t)((n) << 7))  /* 0 = /1, n = /2n; reset 1 */
#define TBCTL_CLKDIV(n)    ((uint16_t)((n) << 10)) /* /2^n */
#define TBCTL_PHSDIR_UP    (1u << 13)
#define TBCTL_FREE_SOFT(n)                                                                                   \
    ((uint16_t)((n) << 14))                 /* debug halt: 0 next count, 1 end of cycle, 2 and 3 free run */
#define TBSTS_CTRDIR        (1u << 0)       /* 1 = counting up */
#define CMPCTL_LOADAMODE(n) ((uint16_t)(n)) /* 0 CTR=0, 1 CTR=PRD, 2 both, 3 freeze */
#define CMPCTL_LOADBMODE(n) ((uint16_t)((n) << 2))
#define CMPCTL_SHDWAMODE    (1u << 4) /* 1 = immediate */
#define CMPCTL_SHDWBMODE    (1u << 6)
#define AQ_NONE             0u
#define AQ_CLEAR            1u
#define AQ_SET              2u
#define AQ_TOGGLE           3u
#define AQCTL_ZRO(n)        ((uint16_t)(n))
#define AQCTL_PRD(n)        ((uint16_t)((n) << 2))
#define AQCTL_CAU(n)        ((uint16_t)((n) << 4))
#define AQCTL_CAD(n)        ((uint16_t)((n) << 6))
#define AQCTL_CBU(n)        ((uint16_t)((n) << 8))
#define AQCTL_CBD(n)        ((uint16_t)((n) << 10))
#define DBCTL_OUT_BOTH      3u        /* both delays on */
#define DBCTL_POLSEL_ALC    (1u << 2) /* active low complementary */
#define DBCTL_POLSEL_AHC    (2u << 2) /* active high complementary */
#define DBCTL_POLSEL_AL     (3u << 2) /* both inverted */
#define DB_MAX              1023u     /* 10 bits */
#define TZSEL_OSHT1         (1u << 8)
#define TZSEL_OSHT(n)       ((uint16_t)(1u << (7u + (n)))) /* n = 1..6 */
#define TZCTL_TZA(n)        ((uint16_t)(n))                /* 0 high impedance, 1 high, 2 low, 3 nothing */
#define TZCTL_TZB(n)        ((uint16_t)((n) << 2))
#define TZ_HIGH             1u
#define TZ_LOW              2u
#define TZ_INT              (1u << 0) /* TZFLG, TZCLR */
#define TZ_CBC              (1u << 1)
#define TZ_OST              (1u << 2)
#define ETSEL_INTSEL(n)     ((uint16_t)(n))
#define ETSEL_INTEN         (1u << 3)
#define ETSEL_SOCASEL(n)    ((uint16_t)((n) << 8))
#define ETSEL_SOCAEN        (1u << 11)
#define ETSEL_SOCBSEL(n)    ((uint16_t)((n) << 12))
#define ETSEL_SOCBEN        (1u << 15)
#define ET_ZERO             1u
#define ET_PERIOD           2u
#define ET_CMPA_UP          4u
#define ET_CMPA_DOWN        5u
#define ET_CMPB_UP          6u
#define ET_CMPB_DOWN        7u
#define ETPS_INTPRD(n)      ((uint16_t)(n))
#define ETPS_SOCAPRD(n)     ((uint16_t)((n) << 8)) /* 0 = off, n = every n-th event */
#define ETPS_SOCBPRD(n)     ((uint16_t)((n) << 12))
#define ET_FLAG_INT         (1u << 0)
#define ET_FLAG_SOCA        (1u << 2)
#define ET_FLAG_SOCB        (1u << 3)

/* ---- eQEP: SPRUG05 ---- */
typedef struct {
    uint32_t QPOSCNT;  /* 00 */
    uint32_t QPOSINIT; /* 02 */
    uint32_t QPOSMAX;  /* 04 */
    uint32_t QPOSCMP;  /* 06 */
    uint32_t QPOSILAT; /* 08 */
    uint32_t QPOSSLAT; /* 0A */
    uint32_t QPOSLAT;  /* 0C latched at unit time-out */
    uint32_t QUTMR;    /* 0E */
    uint32_t QUPRD;    /* 10 */
    uint16_t QWDTMR;   /* 12 */
    uint16_t QWDPRD;   /* 13 */
    uint16_t QDECCTL;  /* 14 */
    uint16_t QEPCTL;   /* 15 */
    uint16_t QCAPCTL;  /* 16 */
    uint16_t QPOSCTL;  /* 17 */
    uint16_t QEINT;    /* 18 */
    uint16_t QFLG;     /* 19 read only */
    uint16_t QCLR;     /* 1A write one to clear */
    uint16_t QFRC;     /* 1B */
    uint16_t QEPSTS;   /* 1C */
    uint16_t QCTMR;    /* 1D */
    uint16_t QCPRD;    /* 1E */
    uint16_t QCTMRLAT; /* 1F */
    uint16_t QCPRDLAT; /* 20 */
    uint16_t reserved21[31];
} eqep_regs_t;

#define QDECCTL_SWAP    (1u << 10)
#define QDECCTL_XCR     (1u << 11)              /* 0 = four counts a line */
#define QDECCTL_QSRC(n) ((uint16_t)((n) << 14)) /* 0 = quadrature */
#define QEPCTL_UTE      (1u << 1)
#define QEPCTL_QCLM     (1u << 2) /* latch on unit time-out */
#define QEPCTL_QPEN     (1u << 3)
#define QEPCTL_SWI      (1u << 7)              /* write one: QPOSCNT = QPOSINIT */
#define QEPCTL_IEI(n)   ((uint16_t)((n) << 8)) /* 2 = QPOSINIT into QPOSCNT at the index */
#define QEPCTL_PCRM(n)                                                                                       \
    ((uint16_t)((n) << 12)) /* 0 index, 1 maximum position, 2 first index, 3 unit time-out */
#define QEPCTL_FREE_SOFT(n) ((uint16_t)((n) << 14))
#define QEP_PHE             (1u << 2) /* quadrature phase error: QFLG, QEINT, QCLR */
#define QEP_UTO             (1u << 11)
#define QEPSTS_QDF          (1u << 5) /* direction, 1 = forward */

/* ---- ADC: SPRU812 ---- */
typedef struct {
    uint16_t ADCTRL1;        /* 00 */
    uint16_t ADCTRL2;        /* 01 */
    uint16_t ADCMAXCONV;     /* 02 */
    uint16_t ADCCHSELSEQ[4]; /* 03-06 */
    uint16_t ADCASEQSR;      /* 07 */
    uint16_t ADCRESULT[16];  /* 08-17, left-justified */
    uint16_t ADCTRL3;        /* 18 */
    uint16_t ADCST;          /* 19 */
    uint16_t reserved1A[2];
    uint16_t ADCREFSEL;  /* 1C */
    uint16_t ADCOFFTRIM; /* 1D */
    uint16_t reserved1E[2];
} adc_regs_t;

typedef struct {
    uint16_t ADCRESULT[16]; /* right-justified, read only */
} adc_mirror_regs_t;

#define ADCTRL1_SEQ_CASC  (1u << 4)
#define ADCTRL1_SEQ_OVRD  (1u << 5)
#define ADCTRL1_CONT_RUN  (1u << 6)
#define ADCTRL1_CPS       (1u << 7)
#define ADCTRL1_ACQ_PS(n) ((uint16_t)((n) << 8)) /* window n + 1 ADCCLK */
#define ADCTRL1_SUSMOD(n)                                                                                    \
    ((uint16_t)((n) << 12)) /* debug halt: 0 continues, 1 ends the sequence, 2 and 3 stop in it */
#define ADCTRL1_SUSMOD_ALL   (3u << 12)
#define ADCTRL1_RESET        (1u << 14)
#define ADCTRL2_SOCA_SEQ1    (1u << 8) /* ePWM SOCA starts SEQ1 */
#define ADCTRL2_INT_MOD_SEQ1 (1u << 10)
#define ADCTRL2_INT_ENA_SEQ1 (1u << 11)
#define ADCTRL2_SOC_SEQ1     (1u << 13)
#define ADCTRL2_RST_SEQ1     (1u << 14)
#define ADCTRL3_SMODE_SEL    (1u << 0) /* simultaneous pairs */
#define ADCTRL3_ADCCLKPS(n)  ((uint16_t)((n) << 1))
#define ADCTRL3_POWER        0x00E0u /* ADCBGRFDN and ADCPWDN */
#define ADCST_INT_SEQ1       (1u << 0)
#define ADCST_SEQ1_BSY       (1u << 2)
#define ADCST_INT_SEQ1_CLR   (1u << 4)

/* ---- SCI: SPRUFZ5 ---- */
typedef struct {
    uint16_t SCICCR;   /* 00 */
    uint16_t SCICTL1;  /* 01 */
    uint16_t SCIHBAUD; /* 02 upper and */
    uint16_t SCILBAUD; /* 03 lower 8 bits of BRR: LSPCLK / (8 (BRR + 1)) */
    uint16_t SCICTL2;  /* 04 */
    uint16_t SCIRXST;  /* 05 read only */
    uint16_t SCIRXEMU; /* 06 read only */
    uint16_t SCIRXBUF; /* 07 read only: reading takes the octet out of the FIFO */
    uint16_t reserved08;
    uint16_t SCITXBUF; /* 09 */
    uint16_t SCIFFTX;  /* 0A */
    uint16_t SCIFFRX;  /* 0B */
    uint16_t SCIFFCT;  /* 0C */
    uint16_t reserved0D[2];
    uint16_t SCIPRI; /* 0F */
} sci_regs_t;

#define SCI_FIFO            16u /* octets of each direction */
#define SCICCR_8N1          7u  /* 8 data bits, no parity, 1 stop bit, idle-line mode */
#define SCICTL1_RXENA       (1u << 0)
#define SCICTL1_TXENA       (1u << 1)
#define SCICTL1_SWRESET     (1u << 5) /* 0 = state machines and flags in reset */
#define SCICTL2_TXEMPTY     (1u << 6)
#define SCICTL2_TXRDY       (1u << 7)
#define SCIRXST_FE          (1u << 4)
#define SCIRXST_BRKDT       (1u << 5) /* nothing more is received until SWRESET */
#define SCIRXST_RXRDY       (1u << 6)
#define SCIRXST_RXERROR     (1u << 7)
#define SCIRXBUF_SCIFFFE    (1u << 15)                     /* this octet had no stop bit */
#define SCIFF_ST(reg)       ((uint16_t)((reg) >> 8 & 31u)) /* SCIFFTX, SCIFFRX: octets in the FIFO */
#define SCIFFTX_TXFIFORESET (1u << 13)                     /* 0 = FIFO empty, held in reset */
#define SCIFFTX_SCIFFENA    (1u << 14)
#define SCIFFTX_SCIRST      (1u << 15) /* 0 = both channels in reset */
#define SCIFFRX_RXFFIL(n)   (n)        /* octets that raise the interrupt */
#define SCIFFRX_RXFFIENA    (1u << 5)  /* the interrupt is on */
#define SCIFFRX_RXFFINTCLR  (1u << 6)  /* write one: clears RXFFINT */
#define SCIFFRX_RXFFINT     (1u << 7)
#define SCIFFRX_RXFIFORESET (1u << 13)
#define SCIFFRX_RXFFOVRCLR  (1u << 14) /* write one: clears RXFFOVF */
#define SCIFFRX_RXFFOVF     (1u << 15) /* more octets arrived than the FIFO can hold */
#define SCIPRI_FREE         (1u << 3)  /* debug halt: run on */

/* ---- I2C: SPRUG03 ---- */
typedef struct {
    uint16_t I2COAR;  /* 00 */
    uint16_t I2CIER;  /* 01 */
    uint16_t I2CSTR;  /* 02 flags: write one to clear AL, NACK, ARDY, SCD */
    uint16_t I2CCLKL; /* 03 SCL is low for this + d module clocks, */
    uint16_t I2CCLKH; /* 04 and high for this + d; d = 7, 6, 5 with IPSC = 0, 1, more */
    uint16_t I2CCNT;  /* 05 octets of a transfer */
    uint16_t I2CDRR;  /* 06 read only: reading takes the octet out of the FIFO */
    uint16_t I2CSAR;  /* 07 address of the slave */
    uint16_t I2CDXR;  /* 08 */
    uint16_t I2CMDR;  /* 09 */
    uint16_t I2CISRC; /* 0A */
    uint16_t reserved0B;
    uint16_t I2CPSC; /* 0C module clock = SYSCLK / (IPSC + 1), 7 to 12 MHz */
    uint16_t reserved0D[0x20 - 0x0D];
    uint16_t I2CFFTX; /* 20 */
    uint16_t I2CFFRX; /* 21 */
    uint16_t reserved22[0x40 - 0x22];
} i2c_regs_t;

#define I2C_FIFO        16u       /* octets of each direction */
#define I2CSTR_AL       (1u << 0) /* arbitration lost */
#define I2CSTR_NACK     (1u << 1) /* an octet was not acknowledged */
#define I2CSTR_ARDY     (1u << 2) /* counter at 0 without STP: the bus is held */
#define I2CSTR_RRDY     (1u << 3)
#define I2CSTR_XRDY     (1u << 4)
#define I2CSTR_SCD      (1u << 5)                      /* a STOP condition was on the bus */
#define I2CSTR_XSMT     (1u << 10)                     /* 0 = transmitter waits for an octet */
#define I2CSTR_BB       (1u << 12)                     /* between START and STOP */
#define I2CMDR_IRS      (1u << 5)                      /* 0 = in reset */
#define I2CMDR_TRX      (1u << 9)                      /* master transmits */
#define I2CMDR_MST      (1u << 10)                     /* falls with the STOP condition */
#define I2CMDR_STP      (1u << 11)                     /* STOP when the counter is at 0; falls then */
#define I2CMDR_STT      (1u << 13)                     /* START; falls then */
#define I2CMDR_FREE     (1u << 14)                     /* debug halt: run on */
#define I2CFF_ST(reg)   ((uint16_t)((reg) >> 8 & 31u)) /* I2CFFTX, I2CFFRX: octets in the FIFO */
#define I2CFFTX_TXFFRST (1u << 13)                     /* 0 = FIFO empty, held in reset */
#define I2CFFTX_I2CFFEN (1u << 14)                     /* both FIFOs in use */
#define I2CFFRX_RXFFRST (1u << 13)

/* ---- The whole map ---- */
typedef struct {
    uint16_t reserved_0000[0x0A80];
    flash_regs_t flash; /* 0A80 */
    uint16_t reserved_0A88[0x0B00 - 0x0A88];
    adc_mirror_regs_t adc_mirror; /* 0B00 */
    uint16_t reserved_0B10[0x0C00 - 0x0B10];
    cpu_timer_regs_t cpu_timer[3]; /* 0C00 */
    uint16_t reserved_0C18[0x0CE0 - 0x0C18];
    pie_regs_t pie; /* 0CE0 */
    uint16_t reserved_0CFA[0x0D00 - 0x0CFA];
    pie_vectors_t pie_vectors; /* 0D00 */
    uint16_t reserved_0E00[0x6800 - 0x0E00];
    epwm_regs_t epwm[6]; /* 6800 */
    uint16_t reserved_6980[0x6B00 - 0x6980];
    eqep_regs_t eqep[2]; /* 6B00 */
    uint16_t reserved_6B80[0x6F80 - 0x6B80];
    gpio_control_regs_t gpio_control[3]; /* 6F80 */
    uint16_t reserved_6FB0[0x6FC0 - 0x6FB0];
    gpio_data_regs_t gpio_data[3]; /* 6FC0 */
    uint16_t reserved_6FD8[0x7010 - 0x6FD8];
    sysctrl_regs_t sysctrl; /* 7010 */
    uint16_t reserved_7030[0x7050 - 0x7030];
    sci_regs_t scia; /* 7050 */
    uint16_t reserved_7060[0x7100 - 0x7060];
    adc_regs_t adc; /* 7100 */
    uint16_t reserved_7120[0x7900 - 0x7120];
    i2c_regs_t i2ca; /* 7900 */
    uint16_t reserved_7940[0x8000u - 0x7940u];
} f28335_t;

/* Offsets in words on any target: offsetof counts chars, a uint16_t is two of them on the host and one on the
 * C28x. */
#define WORDS(type, member) (offsetof(type, member) / sizeof(uint16_t))

#include "hal/f28335/registers_check.h"

#endif
