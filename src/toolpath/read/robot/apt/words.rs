//! Words of APT by what becomes of their records.

/// Records of free text, in which `$` means nothing.
pub(crate) const TEXTS: [&str; 6] = ["PPRINT", "PARTNO", "REMARK", "TPRINT", "LETTER", "PPFUN"];

/// Records that move the tool in ways that are not followed, or change what motions mean.
pub(crate) const REFUSED: &str = "CIRCLE MOVARC CYCLE CUTCOM TRACUT REFSYS TRANS ROTATE ROTABL ROTHED ORIGIN COPY CALL MACRO TERMAC LOOPST \
    LOOPND JUMPTO IF GOLFT GORGT GOFWD GOBACK GOUP GODOWN GO INDIRP INDIRV PSIS THICK TLLFT TLRGT TLON TLAXIS \
    POLYGO NURBS SPLINE INSERT";

/// Records that neither move the tool nor change what motions mean.
pub(crate) const KEPT: &str = "PPRINT PARTNO REMARK TPRINT LETTER PPFUN MACHIN MULTAX COOLNT CUTTER TLDATA TOOL TOOLNO SELCTL TURRET UNLOAD \
    INTOL OUTTOL TOLER MAXANG MAXDP AUXFUN PREFUN OPSTOP STOP DELAY DWELL END END-OF-PATH FINI SEQNO OPTIOM \
    OPSKIP CLEARP CLAMP CLRSRF PAINT TMARK DISPLAY PLABEL CLPRNT NOPOST PRINT PUNCH LINTOL BREAK CHECK ARCSLP \
    LEADER REWIND RESET SET ISN AIR";

/// Whether `word` is one of `words`.
pub(crate) fn is_among(word: &str, words: &str) -> bool {
    words.split_whitespace().any(|own| own == word)
}
