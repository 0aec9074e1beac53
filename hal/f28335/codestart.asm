; Where the boot ROM jumps to: 0x33FFF6, room for one long branch. The boot ROM leaves the watchdog running, and the
; run-time library's set-up of variables may take longer than its 4.37 ms, so it is stopped before anything else (SPRUFB0 ch. 3: WDCR = WDDIS, WDCHK 101).

WDCR        .set    7029h
WDCR_OFF    .set    0068h

            .ref    _c_int00
            .def    code_start

            .sect   "codestart"
code_start: LB      watchdog_off

            .sect   ".text:codestart"
watchdog_off:
            SETC    OBJMODE             ; a debugger may start here without the boot ROM
            EALLOW
            MOVZ    DP, #WDCR >> 6
            MOV     @WDCR, #WDCR_OFF
            EDIS
            LB      _c_int00

            .end
