; void bus_debug_groups(uint16_t mask): which CPU interrupts a debugger in real-time mode lets through while it holds the
; background. DBGIER can be written from the stack only (SPRU430, POP DBGIER); the argument comes in AL (SPRU514).

            .def    bus_debug_groups

            .sect   ".text:bus_debug_groups"
bus_debug_groups:
            MOV     *SP++, AL
            POP     DBGIER
            LRETR

            .end
