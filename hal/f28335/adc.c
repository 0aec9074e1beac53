#include "hal/f28335/adc.h"

#include "hal/f28335/bus.h"
#include "hal/hal.h"

#define PAIRS        4u
#define CHANNELS     0x2102u /* lowest nibble first: A2/B2, A0/B0, A1/B1, A2/B2 */
#define POWER_UP_MS  5u      /* [ms] */
#define ADCTRL1_WORD ((uint16_t)(ADCTRL1_SEQ_CASC | ADCTRL1_ACQ_PS(ADC_ACQ_PS)))
#define ADCTRL2_WORD ((uint16_t)(ADCTRL2_SOCA_SEQ1 | ADCTRL2_INT_ENA_SEQ1))
#define ADCTRL3_WORD ((uint16_t)(ADCTRL3_POWER | ADCTRL3_SMODE_SEL | ADCTRL3_ADCCLKPS(0u)))

void adc_init(void)
{
    bus_write16(&ADC->ADCTRL3, ADCTRL3_WORD);
    bus_wait(HAL_CLOCK_HZ / 1000u * POWER_UP_MS);
    bus_write16(&ADC->ADCTRL1, ADCTRL1_WORD);
    bus_write16(&ADC->ADCMAXCONV, PAIRS - 1u);
    bus_write16(&ADC->ADCCHSELSEQ[0], CHANNELS);
    adc_rearm();
}

void adc_rearm(void)
{
    bus_write16(&ADC->ADCTRL2, ADCTRL2_WORD | ADCTRL2_RST_SEQ1);
    bus_write16(&ADC->ADCST, ADCST_INT_SEQ1_CLR);
}
