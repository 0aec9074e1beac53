/* An empty program, with which a library is linked. */
int main(void)
{
    return 0;
}
