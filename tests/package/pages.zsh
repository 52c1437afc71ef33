# Prints the words with which zsh completes the last of a command line, as a person at a terminal gets them. Arguments: the folder
# of completions, the command line.
zmodload zsh/zpty
zpty shell zsh -f -i
wait_for() {
    local got all=
    while [[ $all != *$1* ]] && zpty -r shell got; do all+=$got; done
}
rm -f ../offered
# compadd is what all completions end in. Here it also notes down the words that match.
zpty -w shell "PS1= fpath=(${(q)1} \$fpath); autoload -U compinit; compinit -u -D"
zpty -w shell 'compadd() {
    local -a found
    (( ${@[(I)-[OAD]]} )) || { builtin compadd -O found "$@"; print -lr -- $found >>../offered }
    builtin compadd "$@"
}'
zpty -w shell 'list() { zle complete-word; print "<e""nd>" }; zle -N list; bindkey "^I" list; print rea""dy'
wait_for ready
zpty -w -n shell "$2"$'\t'
wait_for '<end>'
zpty -d shell
cat ../offered 2>/dev/null
return 0
