"""Bit fields of the F28335's registers that hal/f28335/registers.h declares: their positions and the meaning of their
values. Field names are those of registers.h where it has one, else TI's (SPRUFB0, SPRUG04, SPRU812, SPRUG05, SPRUFZ5).

A field is (name, lowest bit, width, meanings); meanings are the names of the values from 0 up, "a|b|c", or a function that
makes the name of a value, or None."""
import re


def bits(names, first=0):
    """One-bit fields of consecutive numbers; "-" leaves one out."""
    return [(name, first + n, 1, None) for n, name in enumerate(names.split()) if name != "-"]


def pairs(names, meanings):
    """Two-bit fields of consecutive numbers."""
    return [(name, 2 * n, 2, meanings) for n, name in enumerate(names.split())]


HALVES = "/1|/2|/4|/6|/8|/10|/12|/14"
POWERS = "/1|/2|/4|/8|/16|/32|/64|/128"
EVENTS = "none|CTR=0|CTR=PRD|-|CMPA up|CMPA down|CMPB up|CMPB down"
LOADS = "at zero|at period|at both|frozen"
ACTIONS = "none|clear|set|toggle"
EVERY = "off|every|every 2nd|every 3rd"
TRIPPED = "high impedance|high|low|nothing"
ACTION_FIELDS = pairs("ZRO PRD CAU CAD CBU CBD", ACTIONS)
TRIP_FIELDS = bits("INT CBC OST")
EVENT_FIELDS = bits("INT - SOCA SOCB")
CASES = "CBC1 CBC2 CBC3 CBC4 CBC5 CBC6 - - OSHT1 OSHT2 OSHT3 OSHT4 OSHT5 OSHT6"
QEP_FIELDS = bits("INT PCE PHE QDC WTO PCU PCO PCR PCM SEL IEL UTO")

EPWM = {
    "TBCTL": [
        ("CTRMODE", 0, 2, "up|down|up-down|stop"),
        ("PHSEN", 2, 1, None),
        ("PRDLD", 3, 1, "shadow|immediate"),
        ("SYNCOSEL", 4, 2, "SYNCI|CTR=0|CTR=CMPB|off"),
        ("SWFSYNC", 6, 1, None),
        ("HSPCLKDIV", 7, 3, HALVES),
        ("CLKDIV", 10, 3, POWERS),
        ("PHSDIR", 13, 1, "down after sync|up after sync"),
        ("FREE_SOFT", 14, 2, "halt: next count|halt: end of cycle|free run|free run"),
    ],
    "TBSTS": [("CTRDIR", 0, 1, "down|up"), ("SYNCI", 1, 1, None), ("CTRMAX", 2, 1, None)],
    "CMPCTL": [
        ("LOADAMODE", 0, 2, LOADS),
        ("LOADBMODE", 2, 2, LOADS),
        ("SHDWAMODE", 4, 1, "shadow|immediate"),
        ("SHDWBMODE", 6, 1, "shadow|immediate"),
        ("SHDWAFULL", 8, 1, None),
        ("SHDWBFULL", 9, 1, None),
    ],
    "AQCTLA": ACTION_FIELDS,
    "AQCTLB": ACTION_FIELDS,
    "AQSFRC": [
        ("ACTSFA", 0, 2, ACTIONS),
        ("OTSFA", 2, 1, None),
        ("ACTSFB", 3, 2, ACTIONS),
        ("OTSFB", 5, 1, None),
        ("RLDCSF", 6, 2, "at zero|at period|at both|immediate"),
    ],
    "AQCSFRC": [("CSFA", 0, 2, "off|low|high|off"), ("CSFB", 2, 2, "off|low|high|off")],
    "DBCTL": [
        ("OUT_MODE", 0, 2, "no delay|falling edge|rising edge|both edges"),
        ("POLSEL", 2, 2, "active high|active low complementary|active high complementary|active low"),
        ("IN_MODE", 4, 2, "A|B rises, A falls|A rises, B falls|B"),
    ],
    "TZSEL": bits(CASES),
    "TZCTL": [("TZA", 0, 2, TRIPPED), ("TZB", 2, 2, TRIPPED)],
    "TZEINT": bits("CBC OST", 1),
    "TZFLG": TRIP_FIELDS,
    "TZCLR": TRIP_FIELDS,
    "TZFRC": bits("CBC OST", 1),
    "ETSEL": [
        ("INTSEL", 0, 3, EVENTS),
        ("INTEN", 3, 1, None),
        ("SOCASEL", 8, 3, EVENTS),
        ("SOCAEN", 11, 1, None),
        ("SOCBSEL", 12, 3, EVENTS),
        ("SOCBEN", 15, 1, None),
    ],
    "ETPS": [
        ("INTPRD", 0, 2, EVERY),
        ("INTCNT", 2, 2, None),
        ("SOCAPRD", 8, 2, EVERY),
        ("SOCACNT", 10, 2, None),
        ("SOCBPRD", 12, 2, EVERY),
        ("SOCBCNT", 14, 2, None),
    ],
    "ETFLG": EVENT_FIELDS,
    "ETCLR": EVENT_FIELDS,
    "ETFRC": EVENT_FIELDS,
}

EQEP = {
    "QDECCTL": bits("QSP QIP QBP QAP IGATE SWAP", 5)
    + [
        ("XCR", 11, 1, "four counts a line|two counts a line"),
        ("SPSEL", 12, 1, None),
        ("SOEN", 13, 1, None),
        ("QSRC", 14, 2, "quadrature|direction and count|up|down"),
    ],
    "QEPCTL": bits("WDE UTE QCLM QPEN")
    + [
        ("IEL", 4, 2, None),
        ("SEL", 6, 1, None),
        ("SWI", 7, 1, None),
        ("IEI", 8, 2, None),
        ("SEI", 10, 2, None),
        ("PCRM", 12, 2, "reset at index|reset at maximum|reset at first index|reset at time-out"),
        ("FREE_SOFT", 14, 2, "halt: at once|halt: at rollover|free run|free run"),
    ],
    "QCAPCTL": [("UPPS", 0, 4, None), ("CCPS", 4, 3, POWERS), ("CEN", 15, 1, None)],
    "QEINT": QEP_FIELDS,
    "QFLG": QEP_FIELDS,
    "QCLR": QEP_FIELDS,
    "QFRC": QEP_FIELDS,
    "QEPSTS": bits("PCEF FIMF CDEF COEF")
    + [
        ("QDLF", 4, 1, "backward|forward"),
        ("QDF", 5, 1, "backward|forward"),
        ("FIDF", 6, 1, "backward|forward"),
        ("UPEVNT", 7, 1, None),
    ],
}

CHANNELS = "|".join(f"{bank}{n}" for bank in "AB" for n in range(8))
ADC = {
    "ADCTRL1": [
        ("SEQ_CASC", 4, 1, "two sequencers|cascaded"),
        ("SEQ_OVRD", 5, 1, None),
        ("CONT_RUN", 6, 1, "start-stop|continuous"),
        ("CPS", 7, 1, "/1|/2"),
        ("ACQ_PS", 8, 4, "|".join(f"window {n + 1} ADCCLK" for n in range(16))),
        ("SUSMOD", 12, 2, None),
        ("RESET", 14, 1, None),
    ],
    "ADCTRL2": [
        ("SOCB_SEQ2", 0, 1, None),
        ("INT_MOD_SEQ2", 2, 1, None),
        ("INT_ENA_SEQ2", 3, 1, None),
        ("SOC_SEQ2", 5, 1, None),
        ("RST_SEQ2", 6, 1, None),
        ("EXT_SOC_SEQ1", 7, 1, None),
        ("SOCA_SEQ1", 8, 1, None),
        ("INT_MOD_SEQ1", 10, 1, "every end of sequence|every 2nd end of sequence"),
        ("INT_ENA_SEQ1", 11, 1, None),
        ("SOC_SEQ1", 13, 1, None),
        ("RST_SEQ1", 14, 1, None),
        ("SOCB_SEQ", 15, 1, None),
    ],
    "ADCMAXCONV": [("MAX_CONV1", 0, 4, None), ("MAX_CONV2", 4, 3, None)],
    "ADCASEQSR": [("SEQ1_STATE", 0, 4, None), ("SEQ2_STATE", 4, 3, None), ("SEQ_CNTR", 8, 4, None)],
    "ADCTRL3": [
        ("SMODE_SEL", 0, 1, "one by one|pairs"),
        ("ADCCLKPS", 1, 4, "/1|" + "|".join(f"/{2 * n}" for n in range(1, 16))),
        ("POWER", 5, 3, "off|-|-|-|-|-|reference only|on"),
    ],
    "ADCST": bits("INT_SEQ1 INT_SEQ2 SEQ1_BSY SEQ2_BSY INT_SEQ1_CLR INT_SEQ2_CLR EOS_BUF1 EOS_BUF2"),
    "ADCREFSEL": [("REF_SEL", 14, 2, "internal|2.048 V|1.5 V|1.024 V"), ("CALIBRATION", 0, 14, None)],
    "ADCOFFTRIM": [("OFFSET_TRIM", 0, 9, None)],
}
for word in range(4):
    ADC[f"ADCCHSELSEQ[{word}]"] = [(f"CONV{4 * word + n:02}", 4 * n, 4, CHANNELS) for n in range(4)]

SYSCTRL = {
    "PLLSTS": bits("PLLLOCKS - PLLOFF MCLKSTS MCLKCLR OSCOFF MCLKOFF") + [("DIVSEL", 7, 2, "/4|/4|/2|/1")],
    "HISPCP": [("HSPCLK", 0, 3, HALVES)],
    "LOSPCP": [("LSPCLK", 0, 3, HALVES)],
    "PCLKCR0": bits("TBCLKSYNC ADC I2CA SCIC - - SPIA - SCIA SCIB MCBSPA MCBSPB ECANA ECANB", 2),
    "PCLKCR1": bits("EPWM1 EPWM2 EPWM3 EPWM4 EPWM5 EPWM6 - - ECAP1 ECAP2 ECAP3 ECAP4 ECAP5 ECAP6 EQEP1 EQEP2"),
    "PCLKCR3": bits("CPUTIMER0 CPUTIMER1 CPUTIMER2 DMA XINTF GPIOIN", 8),
    "PLLCR": [("DIV", 0, 4, "bypass|" + "|".join(f"x{n}" for n in range(1, 11)))],
    "SCSR": bits("WDOVERRIDE WDENINT WDINTS"),
    "WDCR": [
        ("WDPS", 0, 3, "/1|/1|/2|/4|/8|/16|/32|/64"),
        ("WDCHK", 3, 3, None),
        ("WDDIS", 6, 1, None),
        ("WDFLAG", 7, 1, None),
    ],
    "MAPCNF": bits("MAPEPWM"),
}

SCIA = {
    "SCICCR": [
        ("SCICHAR", 0, 3, "|".join(f"{n} bits" if n > 1 else "1 bit" for n in range(1, 9))),
        ("ADDRIDLE", 3, 1, "idle line|address bit"),
        ("LOOPBKENA", 4, 1, None),
        ("PARITYENA", 5, 1, None),
        ("PARITY", 6, 1, "odd|even"),
        ("STOPBITS", 7, 1, "one|two"),
    ],
    "SCICTL1": bits("RXENA TXENA SLEEP TXWAKE - SWRESET RXERRINTENA"),
    "SCICTL2": bits("TXINTENA RXBKINTENA - - - - TXEMPTY TXRDY"),
    "SCIRXST": bits("RXWAKE PE OE FE BRKDT RXRDY RXERROR", 1),
    "SCIRXBUF": [("RXDT", 0, 8, None), ("SCIFFPE", 14, 1, None), ("SCIFFFE", 15, 1, None)],
    "SCIFFTX": [("TXFFIL", 0, 5, None)]
    + bits("TXFFIENA TXFFINTCLR TXFFINT", 5)
    + [("TXFFST", 8, 5, None)]
    + bits("TXFIFORESET SCIFFENA SCIRST", 13),
    "SCIFFRX": [("RXFFIL", 0, 5, None)]
    + bits("RXFFIENA RXFFINTCLR RXFFINT", 5)
    + [("RXFFST", 8, 5, None)]
    + bits("RXFIFORESET RXFFOVRCLR RXFFOVF", 13),
    "SCIFFCT": [("FFTXDLY", 0, 8, None)] + bits("CDC ABDCLR ABD", 13),
    "SCIPRI": bits("FREE SOFT", 3),
}

FLASH = {
    "FOPT": bits("ENPIPE"),
    "FPWR": [("PWR", 0, 2, "sleep|standby|-|active")],
    "FBANKWAIT": [("RANDWAIT", 0, 4, None), ("PAGEWAIT", 8, 4, None)],
    "FOTPWAIT": [("OTPWAIT", 0, 5, None)],
}

CPUTIMER = {
    "TCR": [("TSS", 4, 1, "runs|stopped")] + bits("TRB - - - - SOFT FREE - - TIE TIF", 5),
    "TPR": [("TDDR", 0, 8, None), ("PSC", 8, 8, None)],
    "TPRH": [("TDDRH", 0, 8, None), ("PSCH", 8, 8, None)],
}

# Sources of the PIE's groups 1, 2, 3 and 5; the others are shown by number.
GROUPS = {
    1: "SEQ1INT SEQ2INT - XINT1 XINT2 ADCINT TINT0 WAKEINT",
    2: "EPWM1_TZ EPWM2_TZ EPWM3_TZ EPWM4_TZ EPWM5_TZ EPWM6_TZ",
    3: "EPWM1 EPWM2 EPWM3 EPWM4 EPWM5 EPWM6",
    5: "EQEP1 EQEP2",
}
PIE = {
    "PIECTRL": [("ENPIE", 0, 1, None), ("PIEVECT", 1, 15, lambda number: f"at {2 * number:#06x}")],
    "PIEACK": bits(" ".join(f"GROUP{n}" for n in range(1, 13))),
}
for group in range(1, 13):
    names = GROUPS.get(group, " ".join(f"INT{group}.{n}" for n in range(1, 9)))
    PIE[f"PIE{group}.IER"] = PIE[f"PIE{group}.IFR"] = bits(names)

# The functions of a pin for the values 1, 2 and 3 of its two bits in MUX1/MUX2 ("?": a function of TI's table that this
# drive does not use).
PIN_FUNCTIONS = {n: f"EPWM{n // 2 + 1}{'AB'[n % 2]}|?|?" for n in range(12)}
PIN_FUNCTIONS.update({12: "TZ1|?|?", 13: "TZ2|?|?", 14: "TZ3|?|?", 15: "TZ4|?|?", 16: "?|?|TZ5", 17: "?|?|TZ6"})
PIN_FUNCTIONS.update({20: "EQEP1A|?|?", 21: "EQEP1B|?|?", 22: "EQEP1S|?|?", 23: "EQEP1I|?|?"})
PIN_FUNCTIONS.update({28: "SCIRXDA|?|?", 29: "SCITXDA|?|?", 35: "SCITXDA|?|?", 36: "SCIRXDA|?|?"})
PIN_FUNCTIONS.update({50: "EQEP1A|?|?", 51: "EQEP1B|?|?", 52: "EQEP1S|?|?", 53: "EQEP1I|?|?"})


def gpio_fields(port):
    """Registers of GPIO port 0 (A), 1 (B) or 2 (C)."""
    pins = [f"GPIO{n}" for n in range(32 * port, min(32 * port + 32, 88))]
    fields = {name: bits(" ".join(pins)) for name in ("DIR", "PUD", "DAT", "SET", "CLEAR", "TOGGLE")}
    fields["CTRL"] = [(f"QUALPRD{n}", 8 * n, 8, None) for n in range(4)]
    for half in range(2):
        some = pins[16 * half : 16 * half + 16]
        fields[f"QSEL{half + 1}"] = pairs(" ".join(some), "sync|3 samples|6 samples|async")
        fields[f"MUX{half + 1}"] = [
            (pin, 2 * n, 2, "gpio|" + PIN_FUNCTIONS.get(int(pin[4:]), "?|?|?")) for n, pin in enumerate(some)
        ]
    return fields


def fields_of(block, register):
    """Fields of "EPWM1", "TBCTL"; [] if the register is one number."""
    family = re.sub(r"[0-9]+$", "", block)
    if family == "GPIOA" or family == "GPIOB" or family == "GPIOC":
        return gpio_fields("ABC".index(family[4])).get(register, [])
    if family == "PIE" and block != "PIE":
        return PIE.get(f"{block}.{register}", [])
    tables = {"EPWM": EPWM, "EQEP": EQEP, "ADC": ADC, "SYSCTRL": SYSCTRL, "SCIA": SCIA,
              "FLASH": FLASH, "CPUTIMER": CPUTIMER, "PIE": PIE}
    return tables.get(family, {}).get(register, [])


def decode(fields, value):
    """[(field, value, meaning or "")], and the set bits that belong to no field."""
    rest = value
    result = []
    for field in fields:
        _, low, width, meanings = field
        mask = (1 << width) - 1
        number = (value >> low) & mask
        rest &= ~(mask << low)
        if callable(meanings):
            meaning = meanings(number)
        else:
            names = meanings.split("|") if meanings else []
            meaning = names[number] if number < len(names) else ""
        result.append((field, number, meaning))
    return result, rest


def summary(fields, value):
    """One line with the fields that are not 0, and those whose value 0 has a name."""
    decoded, rest = decode(fields, value)
    parts = []
    for (name, _, width, meanings), number, meaning in decoded:
        if meaning and not (number == 0 and meaning in ("none", "off", "gpio", "sync")):
            parts.append(f"{name} {meaning}")
        elif number != 0:
            parts.append(name if width == 1 and not meanings else f"{name} {number}")
    if rest and fields:
        parts.append(f"other bits {rest:#06x}")
    return ", ".join(parts)
