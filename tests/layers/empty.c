/* A program of nothing, for a library to be linked with. */
int main(void)
{
    return 0;
}
