/* The least a Cortex-M needs before main: vectors, FPU, .data, .bss, newlib's semihosting files. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
extern uint32_t stack_top[], data_load[], data_start[], data_end[], bss_start[], bss_end[];
extern void initialise_monitor_handles(void);
extern int main(void);
static void fault(void) { exit(2); }
void reset(void)
{
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20; /* CPACR: FPU on */
    __asm volatile("dsb\n isb");
    memcpy(data_start, data_load, (char *)data_end - (char *)data_start);
    memset(bss_start, 0, (char *)bss_end - (char *)bss_start);
    initialise_monitor_handles();
    exit(main());
}
void _init(void) {}
void _fini(void) {}
#define AT(place) ((uintptr_t)(place))
__attribute__((section(".vectors"), used))
static const uintptr_t vectors[16] = { AT(stack_top), AT(reset), AT(fault), AT(fault), AT(fault), AT(fault), AT(fault) };
