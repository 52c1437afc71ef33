# bash completion of @name@ -*- shell-script -*-
# Options and the words that they take are those of --help. bash takes --option=value for three words, since = is one of its breaks.
@function@() {
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} words=: help option
    if [[ $word == '=' ]]; then
        word=
    elif [[ $before == '=' ]]; then
        before=${COMP_WORDS[COMP_CWORD - 2]}
    fi
    COMPREPLY=()
    help=$("${COMP_WORDS[0]}" "${COMP_WORDS[1]}" --help 2>/dev/null)
    help=${help%%$'\nExamples:'*}
    help=${help//$'\n'                         /$'\t'}
    [[ $before == -* ]] && option=$(grep -E -m 1 -- "^  ( *|-., )$before(,| [^ ])" <<<"$help" 2>/dev/null)
    if ((COMP_CWORD == 1)); then
        words='@commands@ --help --version'
    elif [[ $before == -* && $option =~ --[a-z-]+\ ([^ $'\t']+) ]]; then
        case ${BASH_REMATCH[1]} in
        NAME) [[ $option =~ :[$' \t']([^ ,]+(,[$' \t'][^ ,]+)*)$ ]] && words=${BASH_REMATCH[1]//,/} || return ;;
        *.* | FILE | FOLDER | IMAGE) ;;
        *) return ;;
        esac
    elif [[ $word == -* ]]; then
        words=$(sed -nE 's/^  (-.,|   ) (--[a-z-]+).*/\1 \2/p' <<<"$help" | tr -d ,)
    fi
    if [[ $words == : ]]; then
        compopt -o filenames 2>/dev/null
        mapfile -t COMPREPLY < <(compgen -f -- "$word")
    else
        mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
    fi
}
complete -F @function@ @name@
