/* Complete states of an instance: saved, restored, and as bytes that outlive the process. */
#include "instance.h"

typedef struct {
    uint64_t model;  /* hash of the FMU's token: bytes of another FMU are refused */
    uint64_t size;
    State state;
} Snapshot;

static bool belongs(Instance *self, const Snapshot *snapshot)
{
    if (snapshot && snapshot->model == stream_of(MODEL_TOKEN) && snapshot->size == sizeof(State) &&
        snapshot->state.interface == self->s.interface)
        return true;
    report(self, STATUS_ERROR, "the saved state belongs to another FMU or interface");
    return false;
}

bool save_state(Instance *self, void **snapshot)
{
    if (!*snapshot && !(*snapshot = self->allocate(1, sizeof(Snapshot)))) {
        report(self, STATUS_ERROR, "no memory for a saved state");
        return false;
    }
    Snapshot *saved = *snapshot;
    saved->model = stream_of(MODEL_TOKEN);
    saved->size = sizeof(State);
    saved->state = self->s;
    return true;
}

bool restore_state(Instance *self, const void *snapshot)
{
    if (!belongs(self, snapshot))
        return false;
    self->s = ((const Snapshot *)snapshot)->state;
    return true;
}

void free_state(Instance *self, void **snapshot)
{
    if (*snapshot)
        self->release(*snapshot);
    *snapshot = NULL;
}

size_t serialized_size(void)
{
    return sizeof(Snapshot);
}

static bool fits(Instance *self, size_t size, bool exactly)
{
    if (exactly ? size == sizeof(Snapshot) : size >= sizeof(Snapshot))
        return true;
    report(self, STATUS_ERROR, "%lu bytes given for a serialized state of %lu bytes",
           (unsigned long)size, (unsigned long)sizeof(Snapshot));
    return false;
}

bool serialize_state(Instance *self, const void *snapshot, unsigned char *bytes, size_t size)
{
    if (!belongs(self, snapshot) || !fits(self, size, false))
        return false;
    memcpy(bytes, snapshot, sizeof(Snapshot));
    return true;
}

bool deserialize_state(Instance *self, const unsigned char *bytes, size_t size, void **snapshot)
{
    if (!fits(self, size, true))
        return false;
    Snapshot *made = *snapshot ? *snapshot : self->allocate(1, sizeof(Snapshot));
    if (!made) {
        report(self, STATUS_ERROR, "no memory for a saved state");
        return false;
    }
    memcpy(made, bytes, sizeof(Snapshot));
    if (belongs(self, made)) {
        *snapshot = made;
        return true;
    }
    if (!*snapshot)
        self->release(made);
    return false;
}
