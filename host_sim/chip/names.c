/* Texts for the user: names of registers, one line per report. */
#include <stdio.h>
#include <string.h>

#include "host_sim/chip/parts.h"

#define NAME(type, member)                                                                                   \
    {                                                                                                        \
        OFFSET(type, member), #member                                                                        \
    }

typedef struct {
    uint32_t offset;
    const char *name;
} name_t;

typedef struct {
    const char *block;
    uint32_t base, words, copies, stride;
    const name_t *names;
    uint32_t count;
} block_t;

static const name_t flash_names[] = {NAME(flash_regs_t, FOPT),        NAME(flash_regs_t, FPWR),
                                     NAME(flash_regs_t, FSTATUS),     NAME(flash_regs_t, FSTDBYWAIT),
                                     NAME(flash_regs_t, FACTIVEWAIT), NAME(flash_regs_t, FBANKWAIT),
                                     NAME(flash_regs_t, FOTPWAIT)};
static const name_t timer_names[] = {NAME(cpu_timer_regs_t, TIM), NAME(cpu_timer_regs_t, PRD),
                                     NAME(cpu_timer_regs_t, TCR), NAME(cpu_timer_regs_t, TPR),
                                     NAME(cpu_timer_regs_t, TPRH)};
static const name_t pie_names[] = {NAME(pie_regs_t, PIECTRL), NAME(pie_regs_t, PIEACK)};
static const name_t group_names[] = {NAME(pie_group_t, IER), NAME(pie_group_t, IFR)};
static const name_t vector_names[] = {{0u, "vector"}};
static const name_t sysctrl_names[] = {
    NAME(sysctrl_regs_t, PLLSTS),  NAME(sysctrl_regs_t, HISPCP),  NAME(sysctrl_regs_t, LOSPCP),
    NAME(sysctrl_regs_t, PCLKCR0), NAME(sysctrl_regs_t, PCLKCR1), NAME(sysctrl_regs_t, LPMCR0),
    NAME(sysctrl_regs_t, PCLKCR3), NAME(sysctrl_regs_t, PLLCR),   NAME(sysctrl_regs_t, SCSR),
    NAME(sysctrl_regs_t, WDCNTR),  NAME(sysctrl_regs_t, WDKEY),   NAME(sysctrl_regs_t, WDCR),
    NAME(sysctrl_regs_t, MAPCNF)};
static const name_t control_names[] = {NAME(gpio_control_regs_t, CTRL),  NAME(gpio_control_regs_t, QSEL1),
                                       NAME(gpio_control_regs_t, QSEL2), NAME(gpio_control_regs_t, MUX1),
                                       NAME(gpio_control_regs_t, MUX2),  NAME(gpio_control_regs_t, DIR),
                                       NAME(gpio_control_regs_t, PUD)};
static const name_t data_names[] = {NAME(gpio_data_regs_t, DAT), NAME(gpio_data_regs_t, SET),
                                    NAME(gpio_data_regs_t, CLEAR), NAME(gpio_data_regs_t, TOGGLE)};
static const name_t epwm_names[] = {
    NAME(epwm_regs_t, TBCTL),  NAME(epwm_regs_t, TBSTS),   NAME(epwm_regs_t, TBPHSHR),
    NAME(epwm_regs_t, TBPHS),  NAME(epwm_regs_t, TBCTR),   NAME(epwm_regs_t, TBPRD),
    NAME(epwm_regs_t, CMPCTL), NAME(epwm_regs_t, CMPAHR),  NAME(epwm_regs_t, CMPA),
    NAME(epwm_regs_t, CMPB),   NAME(epwm_regs_t, AQCTLA),  NAME(epwm_regs_t, AQCTLB),
    NAME(epwm_regs_t, AQSFRC), NAME(epwm_regs_t, AQCSFRC), NAME(epwm_regs_t, DBCTL),
    NAME(epwm_regs_t, DBRED),  NAME(epwm_regs_t, DBFED),   NAME(epwm_regs_t, TZSEL),
    NAME(epwm_regs_t, TZCTL),  NAME(epwm_regs_t, TZEINT),  NAME(epwm_regs_t, TZFLG),
    NAME(epwm_regs_t, TZCLR),  NAME(epwm_regs_t, TZFRC),   NAME(epwm_regs_t, ETSEL),
    NAME(epwm_regs_t, ETPS),   NAME(epwm_regs_t, ETFLG),   NAME(epwm_regs_t, ETCLR),
    NAME(epwm_regs_t, ETFRC),  NAME(epwm_regs_t, PCCTL),   NAME(epwm_regs_t, HRCNFG)};
static const name_t eqep_names[] = {
    NAME(eqep_regs_t, QPOSCNT), NAME(eqep_regs_t, QPOSINIT), NAME(eqep_regs_t, QPOSMAX),
    NAME(eqep_regs_t, QPOSCMP), NAME(eqep_regs_t, QPOSILAT), NAME(eqep_regs_t, QPOSSLAT),
    NAME(eqep_regs_t, QPOSLAT), NAME(eqep_regs_t, QUTMR),    NAME(eqep_regs_t, QUPRD),
    NAME(eqep_regs_t, QWDTMR),  NAME(eqep_regs_t, QWDPRD),   NAME(eqep_regs_t, QDECCTL),
    NAME(eqep_regs_t, QEPCTL),  NAME(eqep_regs_t, QCAPCTL),  NAME(eqep_regs_t, QPOSCTL),
    NAME(eqep_regs_t, QEINT),   NAME(eqep_regs_t, QFLG),     NAME(eqep_regs_t, QCLR),
    NAME(eqep_regs_t, QFRC),    NAME(eqep_regs_t, QEPSTS),   NAME(eqep_regs_t, QCTMR),
    NAME(eqep_regs_t, QCPRD),   NAME(eqep_regs_t, QCTMRLAT), NAME(eqep_regs_t, QCPRDLAT)};
static const name_t adc_names[] = {NAME(adc_regs_t, ADCTRL1),    NAME(adc_regs_t, ADCTRL2),
                                   NAME(adc_regs_t, ADCMAXCONV), NAME(adc_regs_t, ADCCHSELSEQ),
                                   NAME(adc_regs_t, ADCASEQSR),  NAME(adc_regs_t, ADCRESULT),
                                   NAME(adc_regs_t, ADCTRL3),    NAME(adc_regs_t, ADCST),
                                   NAME(adc_regs_t, ADCREFSEL),  NAME(adc_regs_t, ADCOFFTRIM)};
static const name_t mirror_names[] = {NAME(adc_mirror_regs_t, ADCRESULT)};

static const name_t sci_names[] = {
    NAME(sci_regs_t, SCICCR),   NAME(sci_regs_t, SCICTL1),  NAME(sci_regs_t, SCIHBAUD),
    NAME(sci_regs_t, SCILBAUD), NAME(sci_regs_t, SCICTL2),  NAME(sci_regs_t, SCIRXST),
    NAME(sci_regs_t, SCIRXEMU), NAME(sci_regs_t, SCIRXBUF), NAME(sci_regs_t, SCITXBUF),
    NAME(sci_regs_t, SCIFFTX),  NAME(sci_regs_t, SCIFFRX),  NAME(sci_regs_t, SCIFFCT),
    NAME(sci_regs_t, SCIPRI)};

static const name_t i2c_names[] = {
    NAME(i2c_regs_t, I2COAR),  NAME(i2c_regs_t, I2CIER), NAME(i2c_regs_t, I2CSTR),  NAME(i2c_regs_t, I2CCLKL),
    NAME(i2c_regs_t, I2CCLKH), NAME(i2c_regs_t, I2CCNT), NAME(i2c_regs_t, I2CDRR),  NAME(i2c_regs_t, I2CSAR),
    NAME(i2c_regs_t, I2CDXR),  NAME(i2c_regs_t, I2CMDR), NAME(i2c_regs_t, I2CISRC), NAME(i2c_regs_t, I2CPSC),
    NAME(i2c_regs_t, I2CFFTX), NAME(i2c_regs_t, I2CFFRX)};

#define BLOCK(title, base, words, copies, stride, names)                                                     \
    {                                                                                                        \
        title, base, words, copies, stride, names, (uint32_t)(sizeof(names) / sizeof((names)[0]))            \
    }

/* copies > 1: the title gets a number from 1 on, except where it counts from 0 on silicon. */
static const block_t blocks[] = {BLOCK("FLASH", FLASH_AT, 8u, 1u, 0u, flash_names),
                                 BLOCK("MIRROR", MIRROR_AT, 16u, 1u, 0u, mirror_names),
                                 BLOCK("CPUTIMER", TIMER_AT, 8u, 3u, 8u, timer_names),
                                 BLOCK("PIE", PIE_AT, 2u, 1u, 0u, pie_names),
                                 BLOCK("PIE", PIE_AT + 2u, 2u, 12u, 2u, group_names),
                                 BLOCK("PIE", VECTOR_AT, 256u, 1u, 0u, vector_names),
                                 BLOCK("EPWM", EPWM_AT, 0x40u, 6u, 0x40u, epwm_names),
                                 BLOCK("EQEP", EQEP_AT, 0x40u, 2u, 0x40u, eqep_names),
                                 BLOCK("GPIO", GPIO_CONTROL_AT, 16u, 3u, 16u, control_names),
                                 BLOCK("GPIO", GPIO_DATA_AT, 8u, 3u, 8u, data_names),
                                 BLOCK("SYSCTRL", SYSCTRL_AT, 0x20u, 1u, 0u, sysctrl_names),
                                 BLOCK("SCIA", SCIA_AT, 0x10u, 1u, 0u, sci_names),
                                 BLOCK("ADC", ADC_AT, 0x20u, 1u, 0u, adc_names),
                                 BLOCK("I2CA", I2CA_AT, 0x40u, 1u, 0u, i2c_names)};

static bool is_array(const char *name)
{
    return strcmp(name, "ADCRESULT") == 0 || strcmp(name, "ADCCHSELSEQ") == 0 || strcmp(name, "vector") == 0;
}

const char *chip_register_name(uint32_t address)
{
    static __thread char text[32];
    for (uint32_t b = 0u; b < sizeof blocks / sizeof blocks[0]; b++) {
        const block_t *block = &blocks[b];
        uint32_t copy = block->stride == 0u ? 0u : (address - block->base) / block->stride;
        if (address < block->base || copy >= block->copies) {
            continue;
        }
        uint32_t offset = address - block->base - copy * block->stride;
        if (offset >= block->words) {
            continue;
        }
        for (uint32_t i = block->count; i-- > 0u;) {
            const name_t *name = &block->names[i];
            bool array = is_array(name->name);
            uint32_t limit = i + 1u < block->count ? block->names[i + 1u].offset : block->words;
            if (offset < name->offset || (offset != name->offset && !(array && offset < limit))) {
                continue;
            }
            int used = snprintf(text, sizeof text, "%s", block->block);
            if (block->copies > 1u) {
                bool lettered = strcmp(block->block, "GPIO") == 0;
                bool from_zero = strcmp(block->block, "CPUTIMER") == 0;
                used += lettered
                            ? snprintf(text + used, sizeof text - (size_t)used, "%c", (char)('A' + (int)copy))
                            : snprintf(text + used, sizeof text - (size_t)used, "%u",
                                       copy + (from_zero ? 0u : 1u));
            }
            used += snprintf(text + used, sizeof text - (size_t)used, ".%s", name->name);
            if (array) {
                uint32_t index = (offset - name->offset) / (block->names == vector_names ? 2u : 1u);
                (void)snprintf(text + used, sizeof text - (size_t)used, "[%u]", index);
            }
            return text;
        }
    }
    return "?";
}

const char *chip_report_text(chip_report_kind_t kind)
{
    switch (kind) {
    case CHIP_NOTHING:
        return "nothing wrong";
    case CHIP_PROTECTED_WRITE:
        return "protected register written without EALLOW: ignored";
    case CHIP_CLOCK_OFF:
        return "register of a module without clock written: ignored";
    case CHIP_BAD_WIDTH:
        return "register written with the wrong access width: ignored";
    case CHIP_UNKNOWN_REGISTER:
        return "write to a register or bit that this model does not have: ignored";
    case CHIP_READ_ONLY:
        return "read-only register written: ignored";
    case CHIP_PLL_MISUSE:
        return "PLL or clock divider changed against its rules: ignored";
    case CHIP_NO_VECTOR:
        return "interrupt without a PIE vector: the CPU is lost";
    case CHIP_ADC_OVERRUN:
        return "start of conversion while the ADC sequencer was busy";
    case CHIP_ADC_NOT_POWERED:
        return "conversion before the ADC had been powered for 5 ms: it reads 0";
    case CHIP_ADC_TOO_FAST:
        return "conversion with an ADC clock above 25 MHz";
    case CHIP_WATCHDOG_RESET:
        return "the watchdog reset the chip";
    case CHIP_FLASH_TOO_FAST:
        return "SYSCLK faster than the flash wait states allow";
    case CHIP_SERIAL_LOST:
        return "octet written to a serial transmitter without room, or off: lost";
    case CHIP_FLASH_MISUSE:
        return "flash erased or programmed with interrupts or watchdog on or without its API in L0-L3: "
               "refused";
    case CHIP_FLASH_BEYOND:
        return "flash programmed after the words of a page that this model stores: refused";
    case CHIP_I2C_MISUSE:
        return "I2C clock changed out of reset, or outside 7 to 12 MHz at a START";
    case CHIP_REPORT_KINDS:
        break;
    }
    return "?";
}
