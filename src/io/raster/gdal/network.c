/* SPDX-License-Identifier: Apache-2.0 */
/* GDAL has many ways to the network, and a file can trigger most of them: a description of a map server is
 * recognised under any name, and a VRT may name sources on servers. Here they are closed, layer by layer:  - GDAL's
 * virtual file systems, except those that work on local files;  - drivers, except a list of those that read local
 * files, which also excludes drivers of later versions of GDAL;  - GDAL's own requests;  - requests by libcurl,
 * which netCDF makes without GDAL: they are sent to an unused port of this machine;  - PROJ's, for grids of datum
 * shifts. */

#include "network.h"

#include <cpl_conv.h>
#include <cpl_http.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <errno.h>
#include <gdal.h>
#include <ogr_srs_api.h>
#include <stdlib.h>
#include <string.h>

/* Of Debian's GDAL 3.6 and the versions up to 3.11, those that read from local files; netCDF takes URLs,
 * too. Rasterlite and MBTiles read through SQLite. */
static const char local_drivers[] =
    " VRT DERIVED GTiff COG NITF RPFTOC ECRGTOC HFA SAR_CEOS CEOS JAXAPALSAR GFF ELAS ESRIC AIG AAIGrid GRASSASCIIGrid "
    "ISG"
    " SDTS DTED PNG JPEG MEM JDEM GIF BIGGIF ESAT FITS BSB XPM BMP DIMAP AirSAR RS2 SAFE PCIDSK PCRaster ILWIS SGI "
    "SRTMHGT"
    " Leveller Terragen netCDF HDF4 HDF4Image ISIS3 ISIS2 PDS PDS4 VICAR TIL ERS JP2OpenJPEG L1B FIT GRIB RMF MSGN RST "
    "GSAG"
    " GSBG GS7BG COSAR TSX COASP R MAP WEBP Rasterlite MBTiles CALS SENTINEL2 MRF PNM DOQ1 DOQ2 PAux MFF MFF2 GSC FAST "
    "BT LAN"
    " CPG NDF EIR DIPEx LCP GTX LOSLAS NTv2 CTable2 ACE2 SNODAS KRO ROI_PAC RRASTER BYN ARG RIK USGSDEM GXF BAG HDF5 "
    "HDF5Image"
    " NWT_GRD NWT_GRC ADRG SRP BLX SAGA XYZ HF2 OZI CTG ZMap NGSGEOID IRIS PRF SIGDEM HEIF TGA GPKG GenBin ENVI EHdr "
    "ISCE Zarr"
    " SQLite KEA EXR JPEGXL AVIF LIBERTIFF SNAP_TIFF OpenFileGDB GTI S102 S104 S111 NSIDCbin NOAA_B RCM MiraMonRaster "
    /* Features: */
    " ESRI Shapefile MapInfo File OGR_VRT Memory GeoJSON GeoJSONSeq ESRIJSON TopoJSON KML GPX FlatGeobuf OGR_GMT "
    "JML DXF DGN S57 MapML ODS XLSX CSV ";

static const char local_systems[] =
    " /vsimem/ /vsizip/ /vsigzip/ /vsitar/ /vsi7z/ /vsirar/ /vsisubfile/ /vsisparse/ /vsicrypt/"
    " /vsicached? /vsicellwalk/ ";

static bool closed;
static bool asked; /* something was on its way to the network since gdal_network_reset */
static char **removed_names;
static GDALDriverH *removed;

static bool is_one_of(const char *words, const char *word) {
    char spaced[80];
    return snprintf(spaced, sizeof spaced, " %s ", word) < (int)sizeof spaced && strstr(words, spaced) != NULL;
}

static void *refuse_open(void *context, const char *name, const char *access) {
    (void)name, (void)access;
    if (context != NULL) asked = true;
    errno = EACCES;
    return NULL;
}

static int refuse_stat(void *context, const char *name, VSIStatBufL *about, int flags) {
    (void)name, (void)flags;
    memset(about, 0, sizeof *about);
    if (context != NULL) asked = true;
    errno = EACCES;
    return -1;
}

static CPLHTTPResult *refuse_fetch(const char *url, CSLConstList options, GDALProgressFunc progress,
                                   void *progress_argument, CPLHTTPFetchWriteFunc write, void *write_argument,
                                   void *context) {
    (void)url, (void)options, (void)progress, (void)progress_argument, (void)write, (void)write_argument, (void)context;
    asked = true;
    CPLHTTPResult *result = CPLCalloc(1, sizeof *result);
    result->nStatus = 1;
    result->pszErrBuf = CPLStrdup("the network is off");
    return result;
}

static void close_systems(bool network) {
    VSIFilesystemPluginCallbacksStruct *c = VSIAllocFilesystemPluginCallbacksStruct();
    c->open = refuse_open;
    c->stat = refuse_stat;
    static char **prefixes; /* GDAL 3.6 keeps pointers to them */
    if (prefixes == NULL) prefixes = VSIGetFileSystemsPrefixes();
    for (char **p = prefixes; p != NULL && *p != NULL; p++) {
        /* Standard input may be a terminal or a pipe, and standard output is the program's. */
        const bool standard = strncmp(*p, "/vsistd", 7) == 0;
        if ((*p)[0] == '\0' || (!standard && (network || is_one_of(local_systems, *p)))) continue;
        c->pUserData = standard ? NULL : &asked; /* the standard streams are no network */
        VSIInstallPluginHandler(*p, c);
    }
    VSIFreeFilesystemPluginCallbacksStruct(c);
}

static void close_libcurl(void) {
    static const char *const proxies[] = {"http_proxy", "https_proxy", "HTTPS_PROXY", "ftp_proxy",
                                          "FTP_PROXY",  "all_proxy",   "ALL_PROXY"};
    for (size_t k = 0; k < sizeof proxies / sizeof proxies[0]; k++) setenv(proxies[k], "http://127.0.0.1:9", 1);
    unsetenv("no_proxy");
    unsetenv("NO_PROXY");
}

void gdal_network_close(bool network) {
    closed = !network;
    close_systems(network);
    if (network) return;
    close_libcurl();
    OSRSetPROJEnableNetwork(0);
    CPLHTTPPushFetchCallback(refuse_fetch, NULL);
}

void gdal_network_drivers(void) {
    if (!closed) return;
    for (int k = GDALGetDriverCount() - 1; k >= 0; k--) {
        GDALDriverH driver = GDALGetDriver(k);
        if (is_one_of(local_drivers, GDALGetDriverShortName(driver))) continue;
        const int count = CSLCount(removed_names);
        removed = CPLRealloc(removed, (size_t)(count + 1) * sizeof *removed);
        removed[count] = driver;
        removed_names = CSLAddString(removed_names, GDALGetDriverShortName(driver));
        GDALDeregisterDriver(driver);
    }
}

bool gdal_network_is_url(const char *path) { return closed && strstr(path, "://") != NULL; }

void gdal_network_reset(void) { asked = false; }
bool gdal_network_asked(void) { return asked; }

const char *gdal_network_driver_of(const char *path, unsigned kind) {
    const char *capability = kind == GDAL_OF_RASTER ? GDAL_DCAP_RASTER : GDAL_DCAP_VECTOR;
    const char *name = NULL;
    for (int k = 0; k < CSLCount(removed_names) && name == NULL; k++) {
        if (GDALGetMetadataItem(removed[k], capability, NULL) == NULL) continue;
        const char *only[] = {removed_names[k], NULL};
        GDALRegisterDriver(removed[k]);
        if (GDALIdentifyDriverEx(path, kind, only, NULL) != NULL) name = removed_names[k];
        GDALDeregisterDriver(removed[k]);
    }
    return name;
}
