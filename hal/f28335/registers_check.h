/* Compile-time check of registers.h against the manuals. Included by registers.h only: a wrong
 * offset stops every build that touches a register. Offsets and addresses count 16-bit words: SPRUFB0,
 * SPRUG04, SPRU812, SPRUG05, SPRUFZ5. */
#ifndef HAL_F28335_REGISTERS_CHECK_H
#define HAL_F28335_REGISTERS_CHECK_H

/* Each check declares the same array again, with one element if it holds and with a negative number if not.
 * Therefore a check needs no name, other headers may use the same method, and the object file is not changed.
 */
#define CHECK_LAYOUT(condition)          extern const char check_layout[(condition) ? 1 : -1]
#define CHECK_OFFSET(type, member, word) CHECK_LAYOUT(WORDS(type, member) == (word))
#define CHECK_LENGTH(type, words)        CHECK_LAYOUT(sizeof(type) == (words) * sizeof(uint16_t))
#define CHECK_ADDRESS(member, address)   CHECK_OFFSET(f28335_t, member, address)

/* CPU timer */
CHECK_OFFSET(cpu_timer_regs_t, TIM, 0x00u);
CHECK_OFFSET(cpu_timer_regs_t, PRD, 0x02u);
CHECK_OFFSET(cpu_timer_regs_t, TCR, 0x04u);
CHECK_OFFSET(cpu_timer_regs_t, TPR, 0x06u);
CHECK_OFFSET(cpu_timer_regs_t, TPRH, 0x07u);

/* Flash control */
CHECK_OFFSET(flash_regs_t, FOPT, 0x00u);
CHECK_OFFSET(flash_regs_t, FPWR, 0x02u);
CHECK_OFFSET(flash_regs_t, FSTATUS, 0x03u);
CHECK_OFFSET(flash_regs_t, FSTDBYWAIT, 0x04u);
CHECK_OFFSET(flash_regs_t, FACTIVEWAIT, 0x05u);
CHECK_OFFSET(flash_regs_t, FBANKWAIT, 0x06u);
CHECK_OFFSET(flash_regs_t, FOTPWAIT, 0x07u);

/* PIE */
CHECK_OFFSET(pie_group_t, IER, 0x00u);
CHECK_OFFSET(pie_group_t, IFR, 0x01u);
CHECK_OFFSET(pie_regs_t, PIECTRL, 0x00u);
CHECK_OFFSET(pie_regs_t, PIEACK, 0x01u);
CHECK_OFFSET(pie_regs_t, group[0].IER, 0x02u);
CHECK_OFFSET(pie_regs_t, group[0].IFR, 0x03u);
CHECK_OFFSET(pie_regs_t, group[1].IER, 0x04u);
CHECK_OFFSET(pie_regs_t, group[1].IFR, 0x05u);
CHECK_OFFSET(pie_regs_t, group[2].IER, 0x06u);
CHECK_OFFSET(pie_regs_t, group[2].IFR, 0x07u);
CHECK_OFFSET(pie_regs_t, group[3].IER, 0x08u);
CHECK_OFFSET(pie_regs_t, group[3].IFR, 0x09u);
CHECK_OFFSET(pie_regs_t, group[4].IER, 0x0Au);
CHECK_OFFSET(pie_regs_t, group[4].IFR, 0x0Bu);
CHECK_OFFSET(pie_regs_t, group[5].IER, 0x0Cu);
CHECK_OFFSET(pie_regs_t, group[5].IFR, 0x0Du);
CHECK_OFFSET(pie_regs_t, group[6].IER, 0x0Eu);
CHECK_OFFSET(pie_regs_t, group[6].IFR, 0x0Fu);
CHECK_OFFSET(pie_regs_t, group[7].IER, 0x10u);
CHECK_OFFSET(pie_regs_t, group[7].IFR, 0x11u);
CHECK_OFFSET(pie_regs_t, group[8].IER, 0x12u);
CHECK_OFFSET(pie_regs_t, group[8].IFR, 0x13u);
CHECK_OFFSET(pie_regs_t, group[9].IER, 0x14u);
CHECK_OFFSET(pie_regs_t, group[9].IFR, 0x15u);
CHECK_OFFSET(pie_regs_t, group[10].IER, 0x16u);
CHECK_OFFSET(pie_regs_t, group[10].IFR, 0x17u);
CHECK_OFFSET(pie_regs_t, group[11].IER, 0x18u);
CHECK_OFFSET(pie_regs_t, group[11].IFR, 0x19u);
CHECK_OFFSET(pie_vectors_t, vector[0], 0x00u);
CHECK_OFFSET(pie_vectors_t, vector[PIE_SEQ1INT], 0x40u);
CHECK_OFFSET(pie_vectors_t, vector[PIE_EPWM1_TZ], 0x50u);
CHECK_OFFSET(pie_vectors_t, vector[127], 0xFEu);

/* System control */
CHECK_OFFSET(sysctrl_regs_t, PLLSTS, 0x01u);
CHECK_OFFSET(sysctrl_regs_t, HISPCP, 0x0Au);
CHECK_OFFSET(sysctrl_regs_t, LOSPCP, 0x0Bu);
CHECK_OFFSET(sysctrl_regs_t, PCLKCR0, 0x0Cu);
CHECK_OFFSET(sysctrl_regs_t, PCLKCR1, 0x0Du);
CHECK_OFFSET(sysctrl_regs_t, LPMCR0, 0x0Eu);
CHECK_OFFSET(sysctrl_regs_t, PCLKCR3, 0x10u);
CHECK_OFFSET(sysctrl_regs_t, PLLCR, 0x11u);
CHECK_OFFSET(sysctrl_regs_t, SCSR, 0x12u);
CHECK_OFFSET(sysctrl_regs_t, WDCNTR, 0x13u);
CHECK_OFFSET(sysctrl_regs_t, WDKEY, 0x15u);
CHECK_OFFSET(sysctrl_regs_t, WDCR, 0x19u);
CHECK_OFFSET(sysctrl_regs_t, MAPCNF, 0x1Eu);

/* GPIO */
CHECK_OFFSET(gpio_control_regs_t, CTRL, 0x00u);
CHECK_OFFSET(gpio_control_regs_t, QSEL1, 0x02u);
CHECK_OFFSET(gpio_control_regs_t, QSEL2, 0x04u);
CHECK_OFFSET(gpio_control_regs_t, MUX1, 0x06u);
CHECK_OFFSET(gpio_control_regs_t, MUX2, 0x08u);
CHECK_OFFSET(gpio_control_regs_t, DIR, 0x0Au);
CHECK_OFFSET(gpio_control_regs_t, PUD, 0x0Cu);
CHECK_OFFSET(gpio_data_regs_t, DAT, 0x00u);
CHECK_OFFSET(gpio_data_regs_t, SET, 0x02u);
CHECK_OFFSET(gpio_data_regs_t, CLEAR, 0x04u);
CHECK_OFFSET(gpio_data_regs_t, TOGGLE, 0x06u);

/* ePWM */
CHECK_OFFSET(epwm_regs_t, TBCTL, 0x00u);
CHECK_OFFSET(epwm_regs_t, TBSTS, 0x01u);
CHECK_OFFSET(epwm_regs_t, TBPHSHR, 0x02u);
CHECK_OFFSET(epwm_regs_t, TBPHS, 0x03u);
CHECK_OFFSET(epwm_regs_t, TBCTR, 0x04u);
CHECK_OFFSET(epwm_regs_t, TBPRD, 0x05u);
CHECK_OFFSET(epwm_regs_t, CMPCTL, 0x07u);
CHECK_OFFSET(epwm_regs_t, CMPAHR, 0x08u);
CHECK_OFFSET(epwm_regs_t, CMPA, 0x09u);
CHECK_OFFSET(epwm_regs_t, CMPB, 0x0Au);
CHECK_OFFSET(epwm_regs_t, AQCTLA, 0x0Bu);
CHECK_OFFSET(epwm_regs_t, AQCTLB, 0x0Cu);
CHECK_OFFSET(epwm_regs_t, AQSFRC, 0x0Du);
CHECK_OFFSET(epwm_regs_t, AQCSFRC, 0x0Eu);
CHECK_OFFSET(epwm_regs_t, DBCTL, 0x0Fu);
CHECK_OFFSET(epwm_regs_t, DBRED, 0x10u);
CHECK_OFFSET(epwm_regs_t, DBFED, 0x11u);
CHECK_OFFSET(epwm_regs_t, TZSEL, 0x12u);
CHECK_OFFSET(epwm_regs_t, TZCTL, 0x14u);
CHECK_OFFSET(epwm_regs_t, TZEINT, 0x15u);
CHECK_OFFSET(epwm_regs_t, TZFLG, 0x16u);
CHECK_OFFSET(epwm_regs_t, TZCLR, 0x17u);
CHECK_OFFSET(epwm_regs_t, TZFRC, 0x18u);
CHECK_OFFSET(epwm_regs_t, ETSEL, 0x19u);
CHECK_OFFSET(epwm_regs_t, ETPS, 0x1Au);
CHECK_OFFSET(epwm_regs_t, ETFLG, 0x1Bu);
CHECK_OFFSET(epwm_regs_t, ETCLR, 0x1Cu);
CHECK_OFFSET(epwm_regs_t, ETFRC, 0x1Du);
CHECK_OFFSET(epwm_regs_t, PCCTL, 0x1Eu);
CHECK_OFFSET(epwm_regs_t, HRCNFG, 0x20u);

/* eQEP */
CHECK_OFFSET(eqep_regs_t, QPOSCNT, 0x00u);
CHECK_OFFSET(eqep_regs_t, QPOSINIT, 0x02u);
CHECK_OFFSET(eqep_regs_t, QPOSMAX, 0x04u);
CHECK_OFFSET(eqep_regs_t, QPOSCMP, 0x06u);
CHECK_OFFSET(eqep_regs_t, QPOSILAT, 0x08u);
CHECK_OFFSET(eqep_regs_t, QPOSSLAT, 0x0Au);
CHECK_OFFSET(eqep_regs_t, QPOSLAT, 0x0Cu);
CHECK_OFFSET(eqep_regs_t, QUTMR, 0x0Eu);
CHECK_OFFSET(eqep_regs_t, QUPRD, 0x10u);
CHECK_OFFSET(eqep_regs_t, QWDTMR, 0x12u);
CHECK_OFFSET(eqep_regs_t, QWDPRD, 0x13u);
CHECK_OFFSET(eqep_regs_t, QDECCTL, 0x14u);
CHECK_OFFSET(eqep_regs_t, QEPCTL, 0x15u);
CHECK_OFFSET(eqep_regs_t, QCAPCTL, 0x16u);
CHECK_OFFSET(eqep_regs_t, QPOSCTL, 0x17u);
CHECK_OFFSET(eqep_regs_t, QEINT, 0x18u);
CHECK_OFFSET(eqep_regs_t, QFLG, 0x19u);
CHECK_OFFSET(eqep_regs_t, QCLR, 0x1Au);
CHECK_OFFSET(eqep_regs_t, QFRC, 0x1Bu);
CHECK_OFFSET(eqep_regs_t, QEPSTS, 0x1Cu);
CHECK_OFFSET(eqep_regs_t, QCTMR, 0x1Du);
CHECK_OFFSET(eqep_regs_t, QCPRD, 0x1Eu);
CHECK_OFFSET(eqep_regs_t, QCTMRLAT, 0x1Fu);
CHECK_OFFSET(eqep_regs_t, QCPRDLAT, 0x20u);

/* ADC */
CHECK_OFFSET(adc_regs_t, ADCTRL1, 0x00u);
CHECK_OFFSET(adc_regs_t, ADCTRL2, 0x01u);
CHECK_OFFSET(adc_regs_t, ADCMAXCONV, 0x02u);
CHECK_OFFSET(adc_regs_t, ADCCHSELSEQ[0], 0x03u);
CHECK_OFFSET(adc_regs_t, ADCCHSELSEQ[1], 0x04u);
CHECK_OFFSET(adc_regs_t, ADCCHSELSEQ[2], 0x05u);
CHECK_OFFSET(adc_regs_t, ADCCHSELSEQ[3], 0x06u);
CHECK_OFFSET(adc_regs_t, ADCASEQSR, 0x07u);
CHECK_OFFSET(adc_regs_t, ADCRESULT[0], 0x08u);
CHECK_OFFSET(adc_regs_t, ADCRESULT[15], 0x17u);
CHECK_OFFSET(adc_regs_t, ADCTRL3, 0x18u);
CHECK_OFFSET(adc_regs_t, ADCST, 0x19u);
CHECK_OFFSET(adc_regs_t, ADCREFSEL, 0x1Cu);
CHECK_OFFSET(adc_regs_t, ADCOFFTRIM, 0x1Du);
CHECK_OFFSET(adc_mirror_regs_t, ADCRESULT[0], 0x00u);
CHECK_OFFSET(adc_mirror_regs_t, ADCRESULT[15], 0x0Fu);

/* SCI */
CHECK_OFFSET(sci_regs_t, SCICCR, 0x00u);
CHECK_OFFSET(sci_regs_t, SCICTL1, 0x01u);
CHECK_OFFSET(sci_regs_t, SCIHBAUD, 0x02u);
CHECK_OFFSET(sci_regs_t, SCILBAUD, 0x03u);
CHECK_OFFSET(sci_regs_t, SCICTL2, 0x04u);
CHECK_OFFSET(sci_regs_t, SCIRXST, 0x05u);
CHECK_OFFSET(sci_regs_t, SCIRXEMU, 0x06u);
CHECK_OFFSET(sci_regs_t, SCIRXBUF, 0x07u);
CHECK_OFFSET(sci_regs_t, SCITXBUF, 0x09u);
CHECK_OFFSET(sci_regs_t, SCIFFTX, 0x0Au);
CHECK_OFFSET(sci_regs_t, SCIFFRX, 0x0Bu);
CHECK_OFFSET(sci_regs_t, SCIFFCT, 0x0Cu);
CHECK_OFFSET(sci_regs_t, SCIPRI, 0x0Fu);

/* I2C */
CHECK_OFFSET(i2c_regs_t, I2COAR, 0x00u);
CHECK_OFFSET(i2c_regs_t, I2CIER, 0x01u);
CHECK_OFFSET(i2c_regs_t, I2CSTR, 0x02u);
CHECK_OFFSET(i2c_regs_t, I2CCLKL, 0x03u);
CHECK_OFFSET(i2c_regs_t, I2CCLKH, 0x04u);
CHECK_OFFSET(i2c_regs_t, I2CCNT, 0x05u);
CHECK_OFFSET(i2c_regs_t, I2CDRR, 0x06u);
CHECK_OFFSET(i2c_regs_t, I2CSAR, 0x07u);
CHECK_OFFSET(i2c_regs_t, I2CDXR, 0x08u);
CHECK_OFFSET(i2c_regs_t, I2CMDR, 0x09u);
CHECK_OFFSET(i2c_regs_t, I2CISRC, 0x0Au);
CHECK_OFFSET(i2c_regs_t, I2CPSC, 0x0Cu);
CHECK_OFFSET(i2c_regs_t, I2CFFTX, 0x20u);
CHECK_OFFSET(i2c_regs_t, I2CFFRX, 0x21u);

/* Lengths: the stride of modules that come several times */
CHECK_LENGTH(cpu_timer_regs_t, 0x8u);
CHECK_LENGTH(flash_regs_t, 0x8u);
CHECK_LENGTH(pie_group_t, 0x2u);
CHECK_LENGTH(pie_regs_t, 0x1Au);
CHECK_LENGTH(pie_vectors_t, 0x100u);
CHECK_LENGTH(sysctrl_regs_t, 0x20u);
CHECK_LENGTH(gpio_control_regs_t, 0x10u);
CHECK_LENGTH(gpio_data_regs_t, 0x8u);
CHECK_LENGTH(epwm_regs_t, 0x40u);
CHECK_LENGTH(eqep_regs_t, 0x40u);
CHECK_LENGTH(adc_regs_t, 0x20u);
CHECK_LENGTH(adc_mirror_regs_t, 0x10u);
CHECK_LENGTH(sci_regs_t, 0x10u);
CHECK_LENGTH(i2c_regs_t, 0x40u);
CHECK_LENGTH(f28335_t, 0x8000u);

/* The whole map */
CHECK_ADDRESS(flash, 0x0A80u);
CHECK_ADDRESS(adc_mirror, 0x0B00u);
CHECK_ADDRESS(cpu_timer[0], 0x0C00u);
CHECK_ADDRESS(cpu_timer[1], 0x0C08u);
CHECK_ADDRESS(cpu_timer[2], 0x0C10u);
CHECK_ADDRESS(pie, 0x0CE0u);
CHECK_ADDRESS(pie_vectors, 0x0D00u);
CHECK_ADDRESS(epwm[0], 0x6800u);
CHECK_ADDRESS(epwm[1], 0x6840u);
CHECK_ADDRESS(epwm[2], 0x6880u);
CHECK_ADDRESS(epwm[3], 0x68C0u);
CHECK_ADDRESS(epwm[4], 0x6900u);
CHECK_ADDRESS(epwm[5], 0x6940u);
CHECK_ADDRESS(eqep[0], 0x6B00u);
CHECK_ADDRESS(eqep[1], 0x6B40u);
CHECK_ADDRESS(gpio_control[0], 0x6F80u);
CHECK_ADDRESS(gpio_control[1], 0x6F90u);
CHECK_ADDRESS(gpio_control[2], 0x6FA0u);
CHECK_ADDRESS(gpio_data[0], 0x6FC0u);
CHECK_ADDRESS(gpio_data[1], 0x6FC8u);
CHECK_ADDRESS(gpio_data[2], 0x6FD0u);
CHECK_ADDRESS(sysctrl, 0x7010u);
CHECK_ADDRESS(scia, 0x7050u);
CHECK_ADDRESS(adc, 0x7100u);
CHECK_ADDRESS(i2ca, 0x7900u);

#endif
