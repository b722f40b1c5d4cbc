/* See cfe.h. */
#include "cfe.h"
typedef struct { char object[64], table[64], description[64], file[64]; uint32 size; } CFE_TBL_FileDef_t;
#define CFE_TBL_FILEDEF(object, name, description, file) \
    CFE_TBL_FileDef_t CFE_TBL_FileDef = {#object, #name, #description, #file, sizeof(object)};
