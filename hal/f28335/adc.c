#include "hal/f28335/adc.h"

#include "hal/f28335/bus.h"
#include "hal/hal.h"

#define PAIRS        ((uint16_t)(ADC_LAST + 1))
#define POWER_UP_MS  5u /* [ms] */
#define ADCTRL1_WORD ((uint16_t)(ADCTRL1_SEQ_CASC | ADCTRL1_ACQ_PS(ADC_ACQ_PS)))
#define ADCTRL2_WORD ((uint16_t)(ADCTRL2_SOCA_SEQ1 | ADCTRL2_INT_ENA_SEQ1))
#define ADCTRL3_WORD ((uint16_t)(ADCTRL3_POWER | ADCTRL3_SMODE_SEL | ADCTRL3_ADCCLKPS(0u)))

/* The n-th channel word: four pairs, the first in the lowest nibble. */
#define NIBBLE(word, place, pair)                                                                            \
    ((place) / 4 == (word) && (pair) < 8 ? (uint16_t)((uint16_t)(pair) << (4 * ((place) % 4))) : 0u)
#define CHANNELS(word)                                                                                       \
    ((uint16_t)(NIBBLE(word, 0, ADC_LAST_PAIR) | NIBBLE(word, ADC_PLACE_A, ADC_A) |                          \
                NIBBLE(word, ADC_PLACE_C, ADC_C) | NIBBLE(word, ADC_PLACE_DC, ADC_DC) |                      \
                NIBBLE(word, ADC_PLACE_SINK, ADC_SINK) | NIBBLE(word, ADC_PLACE_MOTOR, ADC_MOTOR)))

/* TI's constants of this chip in the OTP (SPRU812, ADC calibration), in the words of the routine at 0x380080
 * that the boot ROM calls. A constant that was never programmed reads as all ones. */
#define OTP_ADCREFSEL  UINT32_C(0x380083)
#define OTP_ADCOFFTRIM UINT32_C(0x380085)
#define OTP_ERASED     0xFFFFu

static void take_calibration(void)
{
    const uint16_t reference = bus_otp(OTP_ADCREFSEL);
    const uint16_t offset = bus_otp(OTP_ADCOFFTRIM);

    if (reference == OTP_ERASED || offset == OTP_ERASED) {
        return;
    }
    bus_allow();
    bus_write16(&ADC->ADCREFSEL, reference);
    bus_write16(&ADC->ADCOFFTRIM, offset);
    bus_protect();
}

void adc_init(void)
{
    take_calibration();
    bus_write16(&ADC->ADCTRL3, ADCTRL3_WORD);
    bus_wait(HAL_CLOCK_HZ / 1000u * POWER_UP_MS);
    bus_write16(&ADC->ADCTRL1, ADCTRL1_WORD);
    bus_write16(&ADC->ADCMAXCONV, PAIRS - 1u);
    bus_write16(&ADC->ADCCHSELSEQ[0], CHANNELS(0));
    bus_write16(&ADC->ADCCHSELSEQ[1], CHANNELS(1));
    adc_rearm();
}

void adc_rearm(void)
{
    bus_write16(&ADC->ADCTRL2, ADCTRL2_WORD | ADCTRL2_RST_SEQ1);
    bus_write16(&ADC->ADCST, ADCST_INT_SEQ1_CLR);
}
