/* TI's flash API for the F2833x by itself, to run from L0-L3 (tools/flash-api). All numbers count 16-bit words. The table of
 * linker/flash_api.asm comes first; the library's two variables are in one piece with its code, so that the words of the block
 * are all that it needs. Its initial values of variables are never used: the program sets both before each use. */
MEMORY
{
    L0_L3 : origin = 0x008000, length = 0x004000
}

SECTIONS
{
    GROUP : > L0_L3
    {
        flash_table
        .text
        .econst
        .cinit
        .ebss
    }
}
