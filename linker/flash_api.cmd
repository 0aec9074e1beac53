/* Links TI's flash API for the F2833x without other code, to run from L0-L3 (tools/flash-api). All numbers count 16-bit words.
 * The block begins with the table of linker/flash_api.asm. The code and the library's two variables follow in any order, so
 * that the block contains everything that the API needs. The initial values of the variables are not used, because the program
 * sets both before each use. */
MEMORY
{
    L0_L3 : origin = 0x008000, length = 0x004000
}

SECTIONS
{
    flash_table : load = 0x008000
    .text       : > L0_L3
    .econst     : > L0_L3
    .cinit      : > L0_L3
    .ebss       : > L0_L3
}
