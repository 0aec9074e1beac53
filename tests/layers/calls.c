/* A function of a room that calls another room's, which it has declared by hand. */
void CALLS(void *module);
void calls(void *module);

void calls(void *module)
{
    CALLS(module);
}
