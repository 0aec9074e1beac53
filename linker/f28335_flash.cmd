/* F28335, image in flash (data manual SPRS439, EABI section names). All numbers count 16-bit words.
 *
 * The interrupt, and what sets the flash's wait states, is loaded into flash and runs from L0-L3, the program RAM
 * without wait states; hal_boot copies it. Sectors C and B, 0x328000-0x337FFF, are kept for stored parameters: an
 * erase takes a whole sector, so nothing of the program may lie there. Sector A holds nothing but the entry, so that its other
 * special words stay erased: 0x33FF80-0x33FFF5, which belong to the code security module, and its password,
 * 0x33FFF8-0x33FFFF. */
MEMORY
{
    M0_M1      : origin = 0x000050, length = 0x0007B0 /* below: the boot ROM's stack and data */
    L0_L3      : origin = 0x008000, length = 0x004000
    L4_L7      : origin = 0x00C000, length = 0x004000
    FLASH_H_D  : origin = 0x300000, length = 0x028000
    ENTRY      : origin = 0x33FFF6, length = 0x000002
    FPU_TABLES : origin = 0x3FEBDC, length = 0x0006A0 /* boot ROM */
    RESET      : origin = 0x3FFFC0, length = 0x000002 /* boot ROM */
}

SECTIONS
{
    codestart     : > ENTRY
    .text         : > FLASH_H_D
    .cinit        : > FLASH_H_D
    .init_array   : > FLASH_H_D
    .switch       : > FLASH_H_D
    .const        : > FLASH_H_D

    /* The fast library's division is part of the interrupt. */
    .TI.ramfunc   : { *(.TI.ramfunc) -l rts2800_fpu32_fast_supplement_eabi.lib(.text) }
                    LOAD = FLASH_H_D, RUN = L0_L3,
                    LOAD_START(ramfunc_load_start), LOAD_SIZE(ramfunc_load_size), RUN_START(ramfunc_run_start)

    .stack        : > M0_M1, RUN_START(stack_start), RUN_SIZE(stack_size)
    .bss          : > L4_L7
    .data         : > L4_L7
    .sysmem       : > L4_L7

    FPUmathTables : > FPU_TABLES, TYPE = NOLOAD
    .reset        : > RESET, TYPE = DSECT
}
