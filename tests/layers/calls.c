/* A function of one module that calls a function of another module, which this source itself declares. */
void CALLS(void *module);
void calls(void *module);

void calls(void *module)
{
    CALLS(module);
}
