/* ADC with SEQ1 (eight states) or the cascaded sequencer (sixteen): SPRU812, SPRS439 for the timing.
 *
 * In ADCCLK after the start of conversion:
 *     first sample window ends   2.5 + (ACQ_PS + 1)
 *     next ones                  every 2 + ACQ_PS (sequential), 3 + ACQ_PS (simultaneous pairs)
 *     result                     4 after the end of its window, the B result of a pair 5 after it
 * The interrupt flag rises with the last result. Code = floor(4096 V / 3) + ADCOFFTRIM, limited to 0..4095.
 *
 * In start-stop mode the sequencer stays behind its last state: without RST_SEQ1 the next start continues
 * from there, also in the result registers. One start that comes while the sequencer is busy waits; further
 * ones are lost. In this model ADCCLK starts with the conversion, so that it has no phase of its own.
 *
 * Every converter has small errors. TI has measured those of this one and stored the two words that correct
 * them in the OTP; the boot ROM copies these words. Every code is wrong by the part of ADCOFFTRIM that is
 * missing, and the reference is wrong in proportion to the missing part of the calibration in ADCREFSEL.
 *
 * A debugger's halt, ADCTRL1 SUSMOD: with 0 the converter continues; 1 ends the present sequence; 2 and 3
 * interrupt the sequence and continue it afterwards. A start that comes while a halt has stopped the
 * sequencer is lost. */
#include "host_sim/chip/parts.h"

#define READY_TICKS        (CHIP_TICKS_PER_SECOND * 5u / 1000u)     /* band gap and converter */
#define WAKE_TICKS         (CHIP_TICKS_PER_SECOND * 20u / 1000000u) /* converter alone */
#define FASTEST_ADCCLK     6u                                       /* [ticks] 25 MHz */
#define ADCTRL1_STORED     (ADCTRL1_SUSMOD_ALL | 0x0F00u | ADCTRL1_CPS | ADCTRL1_SEQ_CASC)
#define ADCTRL1_UNKNOWN    (ADCTRL1_CONT_RUN | ADCTRL1_SEQ_OVRD)
#define ADCTRL2_SOCB_CASC  (1u << 15)
#define ADCTRL2_STORED     (ADCTRL2_SOCB_CASC | ADCTRL2_INT_ENA_SEQ1 | ADCTRL2_INT_MOD_SEQ1 | ADCTRL2_SOCA_SEQ1)
#define ADCTRL2_UNKNOWN    0x00EDu /* SEQ2 and the external pin */
#define ADCTRL3_BANDGAP    0x00C0u
#define ADCST_EOS_BUF1     (1u << 6)
#define ADCREFSEL_EXTERNAL 0xC000u
#define OTP_REFSEL_AT      0x380083u
#define OTP_OFFTRIM_AT     0x380085u
#define OTP_REFSEL         0x0B5Cu /* this chip's */
#define OTP_OFFTRIM        0x01F7u /* -9: the bare converter reads 9 too high */
#define BARE_GAIN          24.0    /* [codes] error at full scale without the reference calibration */
#define WORST_GAIN         30.0    /* [codes] SPRS439: gain error */

static bool clocked(const chip_t *chip)
{
    return (chip->registers.sysctrl.PCLKCR0 & PCLKCR0_ADC) != 0u;
}

static bool busy(const chip_t *chip)
{
    return chip->adc.next != CHIP_NEVER;
}

static uint32_t susmod(const chip_t *chip)
{
    return (uint32_t)(chip->registers.adc.ADCTRL1 >> 12) & 3u;
}

/* During a halt no sequence begins. */
static bool stopped(const chip_t *chip)
{
    return chip->debug.halted && susmod(chip) != 0u;
}

static uint32_t prescaler(uint32_t n)
{
    return n == 0u ? 1u : 2u * n;
}

static void show_state(chip_t *chip)
{
    chip->registers.adc.ADCASEQSR = (uint16_t)(chip->adc.state | chip->adc.remaining << 8);
}

static void begin(chip_t *chip, uint64_t cycle)
{
    chip_adc_t *adc = &chip->adc;
    adc_regs_t *regs = &chip->registers.adc;
    uint32_t clock = prescaler(chip->registers.sysctrl.HISPCP) * prescaler((regs->ADCTRL3 >> 1) & 15u) *
                     ((regs->ADCTRL1 & ADCTRL1_CPS) != 0u ? 2u : 1u);
    uint32_t conversions = (uint32_t)(regs->ADCMAXCONV & 15u) + 1u;
    uint32_t acquisition = (regs->ADCTRL1 >> 8) & 15u;
    adc->pair = (regs->ADCTRL3 & ADCTRL3_SMODE_SEL) != 0u;
    adc->states = ((regs->ADCTRL1 & ADCTRL1_SEQ_CASC) != 0u ? 16u : 8u) >> adc->pair;
    adc->state &= adc->states - 1u;
    adc->clock = clock;
    adc->spacing = (2u + adc->pair + acquisition) * clock;
    adc->first = cycle + ((2u * acquisition + 7u) * clock + 1u) / 2u;
    adc->remaining = conversions < adc->states ? conversions : adc->states;
    adc->pending = 0u;
    adc->held = 0u;
    adc->published = 0u;
    adc->slot = adc->state << adc->pair;
    adc->powered = (regs->ADCTRL3 & ADCTRL3_POWER) == ADCTRL3_POWER && adc->ready <= chip->tick;
    adc->adjust = !adc->powered || regs->ADCOFFTRIM != OTP_OFFTRIM || regs->ADCREFSEL != OTP_REFSEL;
    regs->ADCST |= ADCST_SEQ1_BSY;
    if (!adc->powered) {
        chip_report(chip, CHIP_ADC_NOT_POWERED, ADC_AT + OFFSET(adc_regs_t, ADCTRL3));
    }
    if (clock * chip->clock.ticks < FASTEST_ADCCLK * chip->clock.cycles) {
        chip_report(chip, CHIP_ADC_TOO_FAST, ADC_AT + OFFSET(adc_regs_t, ADCTRL3));
    }
    adc->next = adc->first;
    chip_tell(chip, CHIP_EVENT_ADC_START, 0u);
    chip_plan(chip, SOURCE_ADC, tick_of(chip, adc->next));
}

void adc_trigger(chip_t *chip, uint64_t cycle, uint32_t mask)
{
    if (!clocked(chip) || stopped(chip) || (chip->registers.adc.ADCTRL2 & mask) == 0u) {
        return;
    }
    if (chip->adc.missing != 0u) {
        chip->adc.missing--;
        return;
    }
    if (!busy(chip)) {
        begin(chip, cycle);
        return;
    }
    chip->adc.pending = 1u;
    chip_report(chip, CHIP_ADC_OVERRUN, ADC_AT + OFFSET(adc_regs_t, ADCTRL2));
}

/* floor(4096 V/3), exactly and without dividing: the estimate differs by one at most, and only next to a
 * whole number; there the comparison of 3 code with 4096 V, both exact, decides. Not-a-number gives 0. */
static inline uint32_t code_of(double volts)
{
    double scaled = 4096.0 * volts;
    if (!(scaled >= 3.0)) {
        return 0u;
    }
    if (scaled >= 3.0 * 4095.0) {
        return 4095u;
    }
    double quotient = scaled * (1.0 / 3.0);
    int32_t code = (int32_t)quotient;
    double rest = quotient - (double)code;
    if (rest < 1e-9 || rest > 1.0 - 1e-9) {
        code -= 3.0 * code > scaled;
        code += 3.0 * (code + 1) <= scaled;
    }
    return (uint32_t)code;
}

static int32_t signed_trim(uint32_t word)
{
    int32_t trim = (int32_t)(word & 0x1FFu);
    return trim >= 256 ? trim - 512 : trim;
}

/* Errors of a conversion compared with the ideal code of the pin's voltage. */
static uint32_t adjusted(const chip_t *chip, uint32_t channel, double volts)
{
    const adc_regs_t *regs = &chip->registers.adc;
    double gain = BARE_GAIN * ((double)regs->ADCREFSEL - (double)OTP_REFSEL) / (double)OTP_REFSEL;
    gain = gain > WORST_GAIN ? WORST_GAIN : gain;
    int32_t trim = signed_trim(regs->ADCOFFTRIM) - signed_trim(OTP_OFFTRIM);
    int32_t whole = (int32_t)code_of(volts * (1.0 + gain / 4096.0)) + trim;
    if (chip->adc.stuck[channel] >= 0) {
        return (uint32_t)chip->adc.stuck[channel];
    }
    if (!chip->adc.powered) {
        return 0u;
    }
    return whole < 0 ? 0u : (whole > 4095 ? 4095u : (uint32_t)whole);
}

static inline uint32_t convert(chip_t *chip, uint32_t channel)
{
    double volts = chip_world->analog(chip_world->context, chip->tick, channel);
    return chip->adc.adjust || chip->adc.stuck[channel] >= 0 ? adjusted(chip, channel, volts)
                                                             : code_of(volts);
}

static void show_results(chip_t *chip, uint32_t end)
{
    chip_adc_t *adc = &chip->adc;
    for (uint32_t i = adc->published; i < end; i++) {
        uint32_t slot = (adc->slot + i) & ((adc->states << adc->pair) - 1u);
        chip->registers.adc.ADCRESULT[slot] = (uint16_t)(adc->result[i] << 4);
        chip->registers.adc_mirror.ADCRESULT[slot] = (uint16_t)adc->result[i];
    }
    adc->published = end;
}

/* The time at which the result of conversion i of the running sequence is in its register. */
static uint64_t result_cycle(const chip_adc_t *adc, uint32_t i)
{
    uint32_t window = i >> adc->pair;
    uint32_t second = i & adc->pair;
    return adc->first + (uint64_t)window * adc->spacing + (uint64_t)(4u + second) * adc->clock;
}

static void publish(chip_t *chip, uint64_t now)
{
    uint32_t end = chip->adc.published;
    while (end < chip->adc.held && result_cycle(&chip->adc, end) <= now) {
        end++;
    }
    show_results(chip, end);
}

void adc_refresh(chip_t *chip)
{
    if (busy(chip) && !chip->debug.adc) {
        publish(chip, cycle_now(chip));
        show_state(chip);
    }
}

static void end_of_sequence(chip_t *chip)
{
    chip_adc_t *adc = &chip->adc;
    adc_regs_t *regs = &chip->registers.adc;
    uint64_t cycle = adc->next;
    show_results(chip, adc->held);
    adc->next = CHIP_NEVER;
    chip->next[SOURCE_ADC] = CHIP_NEVER;
    show_state(chip);
    regs->ADCST &= (uint16_t)~ADCST_SEQ1_BSY;
    bool counts = true;
    if ((regs->ADCTRL2 & ADCTRL2_INT_MOD_SEQ1) != 0u) {
        counts = adc->second != 0u;
        adc->second ^= 1u;
        regs->ADCST = (uint16_t)((regs->ADCST & ~ADCST_EOS_BUF1) | (adc->second ? ADCST_EOS_BUF1 : 0u));
    }
    if (counts && (regs->ADCST & ADCST_INT_SEQ1) == 0u) {
        regs->ADCST |= ADCST_INT_SEQ1;
        if ((regs->ADCTRL2 & ADCTRL2_INT_ENA_SEQ1) != 0u) {
            pie_request(chip, 1u, 1u << 0 | 1u << 5); /* SEQ1INT and ADCINT */
        }
    }
    if (adc->pending && !stopped(chip)) {
        begin(chip, cycle);
    }
}

/* The next conversion of the sequence: its window ends now. */
static inline void hold(chip_t *chip)
{
    chip_adc_t *adc = &chip->adc;
    uint32_t state = adc->state;
    uint32_t first = adc->held;
    uint32_t channel = ((uint32_t)chip->registers.adc.ADCCHSELSEQ[state / 4u] >> (4u * (state % 4u))) & 15u;
    adc->state = (state + 1u) & (adc->states - 1u);
    adc->remaining--;
    adc->next += adc->remaining == 0u ? (4u + adc->pair) * adc->clock : adc->spacing;
    adc->held = first + 1u + adc->pair;
    chip->next[SOURCE_ADC] = tick_of(chip, adc->next);
    if (adc->pair) {
        channel &= 7u;
        adc->result[first] = convert(chip, channel);
        adc->result[first + 1u] = convert(chip, 8u + channel);
    } else {
        adc->result[first] = convert(chip, channel);
    }
}

void adc_event(chip_t *chip)
{
    while (chip->adc.remaining != 0u) {
        hold(chip);
        if (chip->next[SOURCE_ADC] >= chip->limit) {
            return;
        }
        chip->tick = chip->next[SOURCE_ADC];
    }
    end_of_sequence(chip);
}

void adc_schedule(chip_t *chip)
{
    chip_plan(chip, SOURCE_ADC, chip->debug.adc ? CHIP_NEVER : tick_of(chip, chip->adc.next));
}

void adc_halt(chip_t *chip)
{
    chip->debug.adc = busy(chip) && susmod(chip) >= 2u;
    adc_schedule(chip);
}

void adc_go(chip_t *chip)
{
    chip_adc_t *adc = &chip->adc;
    if (chip->debug.adc) {
        uint64_t stood = cycle_now(chip) - chip->debug.cycle;
        chip->debug.adc = 0u;
        adc->first += stood;
        adc->next += stood;
        adc_schedule(chip);
    } else if (adc->pending && !busy(chip)) {
        begin(chip, cycle_now(chip));
    }
}

static void stop(chip_t *chip)
{
    adc_refresh(chip);
    chip->debug.adc = 0u;
    chip->adc.pending = 0u;
    chip->adc.state = 0u;
    chip->adc.remaining = 0u;
    chip->adc.next = CHIP_NEVER;
    chip->next[SOURCE_ADC] = CHIP_NEVER;
    chip->registers.adc.ADCST &= (uint16_t)~ADCST_SEQ1_BSY;
    show_state(chip);
}

/* ADCTRL1 RESET, and power-on: clears everything, the power bits and the calibration included. */
static void registers_reset(chip_t *chip)
{
    stop(chip);
    for (uint32_t i = 0u; i < 4u; i++) {
        chip->registers.adc.ADCCHSELSEQ[i] = 0u;
    }
    chip->registers.adc.ADCTRL1 = 0u;
    chip->registers.adc.ADCTRL2 = 0u;
    chip->registers.adc.ADCTRL3 = 0u;
    chip->registers.adc.ADCMAXCONV = 0u;
    chip->registers.adc.ADCST = 0u;
    chip->registers.adc.ADCREFSEL = 0u;
    chip->registers.adc.ADCOFFTRIM = 0u;
    chip->adc.second = 0u;
}

uint16_t adc_otp(uint32_t address)
{
    switch (address) {
    case OTP_REFSEL_AT:
        return OTP_REFSEL;
    case OTP_OFFTRIM_AT:
        return OTP_OFFTRIM;
    default:
        return 0xFFFFu;
    }
}

void adc_reset(chip_t *chip, bool boot_rom)
{
    chip->adc.next = CHIP_NEVER;
    registers_reset(chip);
    chip->adc.ready = CHIP_NEVER;
    if (boot_rom) {
        chip->registers.adc.ADCREFSEL = OTP_REFSEL;
        chip->registers.adc.ADCOFFTRIM = OTP_OFFTRIM;
    }
}

static void write_power(chip_t *chip, uint16_t value)
{
    adc_regs_t *regs = &chip->registers.adc;
    uint16_t on = value & ADCTRL3_POWER;
    uint16_t was = regs->ADCTRL3 & ADCTRL3_POWER;
    if (on == ADCTRL3_POWER && was != ADCTRL3_POWER) {
        bool awake = (was & ADCTRL3_BANDGAP) == ADCTRL3_BANDGAP && chip->adc.ready != CHIP_NEVER;
        chip->adc.ready = chip->tick + (awake ? WAKE_TICKS : READY_TICKS);
    }
    if ((on & ADCTRL3_BANDGAP) != ADCTRL3_BANDGAP) {
        chip->adc.ready = CHIP_NEVER;
    }
    regs->ADCTRL3 = value & 0x00FFu;
}

static void write_control2(chip_t *chip, uint32_t address, uint16_t value)
{
    if ((value & ADCTRL2_UNKNOWN) != 0u) {
        chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
    }
    chip->registers.adc.ADCTRL2 = value & ADCTRL2_STORED;
    if ((value & ADCTRL2_RST_SEQ1) != 0u) {
        stop(chip); /* a start in the same write is lost */
    } else if ((value & ADCTRL2_SOC_SEQ1) != 0u && !stopped(chip)) {
        if (!busy(chip)) {
            begin(chip, cycle_now(chip));
        } else {
            chip->adc.pending = 1u;
            chip_report(chip, CHIP_ADC_OVERRUN, address);
        }
    }
}

void adc_write(chip_t *chip, uint32_t address, uint16_t value)
{
    adc_regs_t *regs = &chip->registers.adc;
    uint32_t offset = address - ADC_AT;
    if (!clocked(chip)) {
        chip_report(chip, CHIP_CLOCK_OFF, address);
        return;
    }
    switch (offset) {
    case OFFSET(adc_regs_t, ADCTRL1):
        if ((value & ADCTRL1_UNKNOWN) != 0u) {
            chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
        }
        if ((value & ADCTRL1_RESET) != 0u) {
            registers_reset(chip);
            chip->adc.ready = CHIP_NEVER;
        } else {
            regs->ADCTRL1 = value & ADCTRL1_STORED;
        }
        break;
    case OFFSET(adc_regs_t, ADCTRL2):
        write_control2(chip, address, value);
        break;
    case OFFSET(adc_regs_t, ADCMAXCONV):
        regs->ADCMAXCONV = value & 0x007Fu;
        break;
    case OFFSET(adc_regs_t, ADCCHSELSEQ[0]):
    case OFFSET(adc_regs_t, ADCCHSELSEQ[1]):
    case OFFSET(adc_regs_t, ADCCHSELSEQ[2]):
    case OFFSET(adc_regs_t, ADCCHSELSEQ[3]):
        regs->ADCCHSELSEQ[offset - OFFSET(adc_regs_t, ADCCHSELSEQ)] = value;
        break;
    case OFFSET(adc_regs_t, ADCTRL3):
        write_power(chip, value);
        break;
    case OFFSET(adc_regs_t, ADCST):
        if ((value & ADCST_INT_SEQ1_CLR) != 0u) {
            regs->ADCST &= (uint16_t)~ADCST_INT_SEQ1;
        }
        break;
    case OFFSET(adc_regs_t, ADCREFSEL):
        if ((value & ADCREFSEL_EXTERNAL) != 0u) {
            chip_report(chip, CHIP_UNKNOWN_REGISTER, address);
        } else {
            regs->ADCREFSEL = value;
        }
        break;
    case OFFSET(adc_regs_t, ADCOFFTRIM):
        regs->ADCOFFTRIM = value & 0x01FFu;
        break;
    default:
        chip_report(chip,
                    offset == OFFSET(adc_regs_t, ADCASEQSR) ||
                            (offset >= OFFSET(adc_regs_t, ADCRESULT) && offset < OFFSET(adc_regs_t, ADCTRL3))
                        ? CHIP_READ_ONLY
                        : CHIP_UNKNOWN_REGISTER,
                    address);
        break;
    }
}
