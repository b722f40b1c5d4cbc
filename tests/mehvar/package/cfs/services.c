/* Services for one run of the app: messages that come, tables that are loaded, and a log of what it does. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "satellite_mrac_app.h"

static satellite_mrac_parameters table;
static satellite_mrac_state twin; /* steps beside the app */
static CFE_TBL_CallbackFuncPtr_t validate;
static satellite_mrac_input input;
static CFE_MSG_CommandHeader_t order;
static int turn, updated;

bool CFE_ES_RunLoop(uint32 *status) { return *status == CFE_ES_RunStatus_APP_RUN && turn < 8; }
void CFE_ES_ExitApp(uint32 status) { printf("exit %u\n", (unsigned)status); }
CFE_Status_t CFE_EVS_Register(const void *f, uint16 n, uint16 s) { return (void)f, (void)n, (void)s, CFE_SUCCESS; }
CFE_Status_t CFE_EVS_SendEvent(uint16 id, uint16 type, const char *format, ...)
{
    va_list rest;
    va_start(rest, format);
    printf("event %u %u ", (unsigned)id, (unsigned)type);
    vprintf(format, rest);
    putchar('\n');
    va_end(rest);
    return CFE_SUCCESS;
}
CFE_Status_t CFE_SB_CreatePipe(CFE_SB_PipeId_t *p, uint16 d, const char *n) { return *p = 1, (void)d, (void)n, CFE_SUCCESS; }
CFE_Status_t CFE_SB_Subscribe(CFE_SB_MsgId_t id, CFE_SB_PipeId_t pipe) { return (void)id, (void)pipe, CFE_SUCCESS; }
void CFE_SB_TimeStampMsg(CFE_MSG_Message_t *message) { (void)message; }
CFE_Status_t CFE_MSG_Init(CFE_MSG_Message_t *m, CFE_SB_MsgId_t id, CFE_MSG_Size_t size)
{
    return m->id = id, m->size = size, m->code = 0, CFE_SUCCESS;
}
CFE_Status_t CFE_MSG_GetMsgId(const CFE_MSG_Message_t *m, CFE_SB_MsgId_t *id) { return *id = m->id, CFE_SUCCESS; }
CFE_Status_t CFE_MSG_GetSize(const CFE_MSG_Message_t *m, CFE_MSG_Size_t *size) { return *size = m->size, CFE_SUCCESS; }
CFE_Status_t CFE_MSG_GetFcnCode(const CFE_MSG_Message_t *m, CFE_MSG_FcnCode_t *c) { return *c = m->code, CFE_SUCCESS; }
CFE_Status_t CFE_TBL_Register(CFE_TBL_Handle_t *t, const char *n, size_t size, uint16 o, CFE_TBL_CallbackFuncPtr_t call)
{
    validate = call;
    return *t = 1, (void)n, (void)o, size == sizeof table ? CFE_SUCCESS : -1;
}
CFE_Status_t CFE_TBL_Load(CFE_TBL_Handle_t t, CFE_TBL_SrcEnum_t source, const void *data)
{
    satellite_mrac_parameters copy;
    memcpy(&copy, data, sizeof copy);
    (void)t, (void)source;
    if (validate(&copy) != CFE_SUCCESS) return -1;
    table = copy;
    updated = 1;
    return CFE_SUCCESS;
}
CFE_Status_t CFE_TBL_Manage(CFE_TBL_Handle_t t) { return (void)t, CFE_SUCCESS; }
CFE_Status_t CFE_TBL_GetAddress(void **address, CFE_TBL_Handle_t t)
{
    const int status = updated ? CFE_TBL_INFO_UPDATED : CFE_SUCCESS;
    updated = 0;
    return *address = &table, (void)t, status;
}
CFE_Status_t CFE_TBL_ReleaseAddress(CFE_TBL_Handle_t t) { return (void)t, CFE_SUCCESS; }

static CFE_Status_t evaluate(CFE_SB_Buffer_t **buffer, mv_real roll)
{
    CFE_MSG_Init(&input.header.Msg, SATELLITE_MRAC_INPUT_MID, sizeof input);
    input.measured[SATELLITE_MRAC_MEASURED_ROLL] = roll;
    *buffer = (CFE_SB_Buffer_t *)&input;
    return CFE_SUCCESS;
}

static CFE_Status_t tell(CFE_SB_Buffer_t **buffer, CFE_MSG_FcnCode_t code, CFE_MSG_Size_t size)
{
    CFE_MSG_Init(&order.Msg, SATELLITE_MRAC_CMD_MID, size);
    order.Msg.code = code;
    *buffer = (CFE_SB_Buffer_t *)&order;
    return CFE_SUCCESS;
}

CFE_Status_t CFE_SB_ReceiveBuffer(CFE_SB_Buffer_t **buffer, CFE_SB_PipeId_t pipe, int32 timeout)
{
    satellite_mrac_parameters other = satellite_mrac_defaults;
    (void)pipe, (void)timeout;
    switch (turn++) {
    case 0: return evaluate(buffer, 0.02f);
    case 1: return evaluate(buffer, 0.03f);
    case 2:
        other.law[SATELLITE_MRAC_LAW_FORGETTING] = 3;
        satellite_mrac_seal(&other);
        printf("load %d\n", CFE_TBL_Load(1, CFE_TBL_SRC_ADDRESS, &other));
        return tell(buffer, SATELLITE_MRAC_NOOP_CC, sizeof order);
    case 3:
        other.law[SATELLITE_MRAC_LAW_FORGETTING] = 0.9f;
        satellite_mrac_seal(&other);
        printf("load %d\n", CFE_TBL_Load(1, CFE_TBL_SRC_ADDRESS, &other));
        satellite_mrac_set(&twin, &table);
        return evaluate(buffer, 0.05f);
    case 4: return evaluate(buffer, (mv_real)(0.0 / 0.0));
    case 5: return tell(buffer, 9, sizeof order);
    case 6: return tell(buffer, SATELLITE_MRAC_NOOP_CC, 3);
    default: return tell(buffer, SATELLITE_MRAC_RESET_CC, sizeof order);
    }
}

CFE_Status_t CFE_SB_TransmitMsg(const CFE_MSG_Message_t *message, bool origination)
{
    const satellite_mrac_output *output = (const satellite_mrac_output *)message;
    mv_real command[SATELLITE_MRAC_NCOMMAND];
    (void)origination;
    if (!twin.parameters) satellite_mrac_init(&twin, &satellite_mrac_defaults);
    satellite_mrac_step(&twin, input.measured, input.reference, command);
    const int same = memcmp(command, output->command, sizeof command) == 0 &&
                     memcmp(satellite_mrac_memory(&twin), output->memory, sizeof output->memory) == 0;
    printf("output %u flags %u %s\n", (unsigned)output->steps, (unsigned)output->flags, same ? "same bits" : "other bits");
    return CFE_SUCCESS;
}

int main(void)
{
    SATELLITE_MRAC_AppMain();
    return 0;
}
