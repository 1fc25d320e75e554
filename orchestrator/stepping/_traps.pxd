"""Ends a stretch of steps, not the process, where arithmetic in an FMU traps (SIGFPE).

Left alone: a host that has a handler of its own, threads that an FMU started, and Python code (in a
Python FMU), out of which there is no jump.
"""

cdef extern from *:
    """
    #define TRAP 110  /* as in log: the first of our own statuses for traps */
    #if defined _WIN32
    #define BEGIN_TRAPS() ((void)0)
    #define TRAPPED() 0
    #define END_TRAPS() ((void)0)
    #define WHICH_TRAP() TRAP
    #else
    #include <fenv.h>
    #include <setjmp.h>
    #include <signal.h>
    #include <stddef.h>
    static _Thread_local sigjmp_buf trap_way_back;
    static _Thread_local volatile sig_atomic_t trap_armed, trap_which;
    static _Thread_local fenv_t trap_arithmetic;

    static int trap_status(int code)
    {
        switch (code) {
        case FPE_INTDIV: return TRAP + 1;
        case FPE_INTOVF: return TRAP + 2;
        case FPE_FLTDIV: return TRAP + 3;
        case FPE_FLTOVF: return TRAP + 4;
        case FPE_FLTUND: return TRAP + 5;
        case FPE_FLTRES: return TRAP + 6;
        case FPE_FLTINV: return TRAP + 7;
        default: return TRAP;
        }
    }

    static void on_trap(int number, siginfo_t *info, void *context)
    {
        (void)context;
        if (trap_armed && !PyGILState_Check()) {
            trap_which = trap_status(info->si_code);
            siglongjmp(trap_way_back, 1);
        }
        signal(number, SIG_DFL); /* and the same instruction again, or what raised it */
        if (info->si_code <= 0)
            raise(number);
    }

    static void begin_traps(void)
    {
        struct sigaction before, ours = {.sa_sigaction = on_trap, .sa_flags = SA_SIGINFO};
        if (sigaction(SIGFPE, NULL, &before) || before.sa_handler != SIG_DFL)
            return;
        fegetenv(&trap_arithmetic);
        trap_armed = !sigaction(SIGFPE, &ours, NULL);
    }

    static void end_traps(void)
    {
        struct sigaction now;
        if (!trap_armed)
            return;
        trap_armed = 0;
        if (!sigaction(SIGFPE, NULL, &now) && now.sa_sigaction == on_trap)
            signal(SIGFPE, SIG_DFL);
    }

    static int which_trap(void)
    {
        fesetenv(&trap_arithmetic);
        return trap_which;
    }

    #define BEGIN_TRAPS() begin_traps()
    #define TRAPPED() (trap_armed && sigsetjmp(trap_way_back, 1))
    #define END_TRAPS() end_traps()
    #define WHICH_TRAP() which_trap()
    #endif
    """
    void BEGIN_TRAPS() noexcept nogil
    bint TRAPPED() noexcept nogil  # returns once more, as true, where something trapped
    void END_TRAPS() noexcept nogil
    int WHICH_TRAP() noexcept nogil  # the status to tell
