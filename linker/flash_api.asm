; The table at the head of TI's flash API where this program uses it: tools/flash-api assembles it in the object format COFF
; and links it with the library alone, by linker/flash_api.cmd. hal/f28335/flash_api.h has the place of each entry. A call of
; an entry is a call of the function behind it: the branch leaves the return address as it is.

            .ref    _Flash28335_Erase, _Flash28335_Program, _Flash28335_Verify, _Flash28335_APIVersionHex
            .ref    _Flash_CPUScaleFactor, _Flash_CallbackPtr
            .def    _flash_api

            .sect   "flash_table"
_flash_api: LB      _Flash28335_Erase
            LB      _Flash28335_Program
            LB      _Flash28335_Verify
            LB      _Flash28335_APIVersionHex
            .long   _Flash_CPUScaleFactor
            .long   _Flash_CallbackPtr

            .end
